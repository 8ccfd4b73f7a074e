import assert from "node:assert/strict";
import { afterEach, beforeEach, mock, test } from "node:test";
import { Link, pictureOf, QUIET_MS, Rate, waitBefore } from "../../static/js/net/link.js";
import { FakeSocket } from "./fake-socket.js";

let now = 0;
/** @param {number} ms */
function pass(ms) {
  for (let left = ms; left > 0; left -= 50) {
    now += 50;
    mock.timers.tick(50);
  }
}

/** A link, and what it told. */
function linked() {
  /** @type {string[]} */
  const heard = [];
  let lost = 0;
  const link = new Link({
    url: "ws://robot/ws",
    hear: ({ kind }) => heard.push(kind),
    see: () => heard.push("picture"),
    lose: () => (lost += 1),
  });
  link.open();
  return { link, heard, lost: () => lost };
}

beforeEach(() => {
  FakeSocket.all = [];
  now = 1000;
  Object.assign(globalThis, { WebSocket: FakeSocket });
  mock.method(performance, "now", () => now);
  mock.timers.enable({ apis: ["setTimeout", "setInterval"] });
});

afterEach(() => {
  mock.timers.reset();
  mock.restoreAll();
});

const newest = () => /** @type {FakeSocket} */ (FakeSocket.all.at(-1));

test("the wait doubles to eight seconds and is spread by a quarter", () => {
  for (const attempt of [0, 1, 2, 3, 4, 20]) {
    const middle = Math.min(500 * 2 ** attempt, 8000);
    assert.equal(waitBefore(attempt, 0.5), middle);
    assert.equal(waitBefore(attempt, 0), 0.75 * middle);
    assert.equal(waitBefore(attempt, 1), 1.25 * middle);
  }
});

test("the link is up with the hello, not before", () => {
  const { link } = linked();
  assert.equal(link.health.is, "opening");
  newest().tell({ kind: "hello" });
  assert.equal(link.health.is, "up");
});

test("a socket that ends is opened again after a while, and at once known as down", () => {
  const { link, lost } = linked();
  newest().tell({ kind: "hello" });
  newest().gone();
  assert.equal(link.health.is, "down");
  assert.equal(lost(), 1);
  assert.equal(FakeSocket.all.length, 1);
  pass(700);
  assert.equal(FakeSocket.all.length, 2);
  newest().tell({ kind: "hello" });
  assert.equal(link.health.is, "up");
});

test("attempts that fail come further and further apart, and a success begins anew", () => {
  linked();
  /** @type {number[]} */
  const gaps = [];
  for (let attempt = 0; attempt < 4; attempt += 1) {
    const [count, from] = [FakeSocket.all.length, now];
    newest().gone();
    while (FakeSocket.all.length === count) pass(50);
    gaps.push(now - from);
  }
  assert.ok(
    gaps.every((gap, index) => index === 0 || gap > 1.1 * (gaps[index - 1] ?? 0)),
    String(gaps),
  );
  newest().tell({ kind: "hello" });
  newest().gone();
  const count = FakeSocket.all.length;
  pass(700);
  assert.equal(FakeSocket.all.length, count + 1);
});

test("a socket that falls silent without ending is given up", () => {
  const { link, lost } = linked();
  newest().tell({ kind: "hello" });
  pass(QUIET_MS + 400);
  assert.equal(lost(), 1);
  assert.equal(link.health.is, "down");
});

test("a console that is slow to answer is given more time at each attempt", () => {
  linked();
  /** @type {number[]} */
  const patience = [];
  for (let attempt = 0; attempt < 6; attempt += 1) {
    const [count, from] = [FakeSocket.all.length, now];
    while (newest().readyState < 2) pass(50);
    patience.push(now - from);
    while (FakeSocket.all.length === count) pass(50);
  }
  const [first = 0, second = 0, third = 0] = patience;
  assert.ok(first < QUIET_MS + 400 && second > 1.8 * first && third > 1.8 * second, String(patience));
  assert.ok((patience.at(-1) ?? 0) < 30_500, String(patience));
});

test("a page that was busy itself does not blame the socket", () => {
  const { link, lost } = linked();
  newest().tell({ kind: "hello" });
  pass(400);
  now += 2 * QUIET_MS;
  mock.timers.tick(200);
  newest().tell({ kind: "state" });
  pass(400);
  assert.equal(lost(), 0);
  assert.equal(link.health.is, "up");
});

test("signed out is for good", () => {
  const { link } = linked();
  newest().tell({ kind: "hello" });
  link.close();
  newest().gone();
  pass(20000);
  assert.equal(FakeSocket.all.length, 1);
});

test("a moving order is not put behind a jam, a zero is", () => {
  const { link } = linked();
  newest().tell({ kind: "hello" });
  newest().bufferedAmount = 100000;
  const order = /** @type {const} */ ({ kind: "drive", w: 0, press: 1, seq: 1, nonce: 1, epoch: 1 });
  assert.equal(link.send({ ...order, v: 0.1 }), false);
  assert.equal(link.send({ ...order, v: 0 }), true);
  assert.equal(link.send({ kind: "stop" }), true);
});

test("the round trip is measured with the number that comes back", () => {
  const { link, heard } = linked();
  newest().tell({ kind: "hello" });
  pass(1200);
  const echo = newest()
    .sent.map((text) => JSON.parse(text))
    .find(({ kind }) => kind === "echo");
  now = echo.t + 42;
  newest().tell(echo);
  assert.equal(link.health.round_trip_ms, 42);
  assert.deepEqual(heard, ["hello"]);
});

test("a page whose timers stand still shows by what it hears that it is alive", () => {
  linked();
  newest().tell({ kind: "hello" });
  const echoes = () => newest().sent.filter((text) => JSON.parse(text).kind === "echo").length;
  for (let count = 0; count < 100; count += 1) {
    now += 50;
    newest().tell({ kind: "state" });
  }
  assert.ok(echoes() >= 4 && echoes() <= 5);
});

test("the age of the state grows and its rate is counted", () => {
  const { link } = linked();
  newest().tell({ kind: "hello" });
  for (let count = 0; count < 20; count += 1) {
    pass(50);
    newest().tell({ kind: "state" });
  }
  assert.ok(Math.abs(link.health.rate_hz - 20) < 0.5);
  pass(900);
  assert.ok(Math.abs(link.health.age_s - 0.9) < 0.01);
});

test("a rate is nothing before the second message and after a silence", () => {
  const rate = new Rate();
  assert.equal(rate.hertz(0), 0);
  rate.mark(0);
  assert.equal(rate.hertz(10), 0);
  rate.mark(100);
  assert.equal(rate.hertz(100), 10);
  assert.equal(rate.hertz(5000), 0);
});

test("a picture is what the header says, and anything else is none", () => {
  const bytes = new Uint8Array([1, 0, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xf8, 0x3f, 0xff, 0xd8]);
  const picture = pictureOf(bytes.buffer);
  assert.deepEqual([picture?.seq, picture?.stamp, picture?.jpeg.length], [7, 1.5, 2]);
  bytes[0] = 2;
  assert.equal(pictureOf(bytes.buffer), null);
  assert.equal(pictureOf(new ArrayBuffer(16)), null);
});
