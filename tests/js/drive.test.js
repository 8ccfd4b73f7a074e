import assert from "node:assert/strict";
import { test } from "node:test";
import { ASK_MS, Drive, LATE_MS, NEUTRAL_MS, PERIOD_MS, PRESETS, SLOW, ZEROS } from "../../static/js/drive/drive.js";

/** @import { DriveFrame, Permission } from "../../static/js/drive/drive.js" */

const FORWARD = { v: 1, w: 0 };
const NOTHING = { v: 0, w: 0 };
/** @type {Permission} */
const YES = { may: "yes", why: "" };
/** @type {Permission} */
const ASK = { may: "ask", why: "" };

/** A page with a clock of its own. */
function page() {
  /** @type {DriveFrame[]} */
  const sent = [];
  let [presses, asked, now, busy] = [0, 0, 1000, 0];
  const drive = new Drive({
    send: (frame) => sent.push(frame),
    ask: () => (asked += 1),
    draw: () => (presses += 1),
    count: () => 5000,
    busy: () => (busy += 1),
  });
  drive.limits = { speed: 0.3, turnRate: 1.5 };
  const gate = { nonce: 7, epoch: 2, needNeutral: false };
  const self = {
    drive,
    sent,
    gate,
    get busy() {
      return busy;
    },
    permission: YES,
    get asked() {
      return asked;
    },
    get now() {
      return now;
    },
    /** The newest state arrives. */
    hear() {
      gate.nonce += 1;
      drive.hear({ ...gate }, self.permission, now);
    },
    /** @param {number} ms */
    wait(ms) {
      for (const end = now + ms; now < end; ) {
        now += PERIOD_MS;
        self.hear();
        drive.tick(now);
      }
    },
    /** @param {{v: number, w: number}} velocity */
    keys: (velocity) => drive.keys(velocity, now),
    moving: () => sent.filter(({ v, w }) => v !== 0 || w !== 0),
  };
  self.hear();
  return self;
}

test("a held key sends at once and then twenty times a second", () => {
  const p = page();
  p.keys(FORWARD);
  assert.equal(p.sent.length, 1);
  p.wait(1000);
  assert.equal(p.sent.length, 21);
  assert.ok(p.sent.every(({ v }) => v > 0));
});

test("letting go sends zero at once, three in all, then nothing", () => {
  const p = page();
  p.keys(FORWARD);
  p.wait(200);
  const before = p.sent.length;
  p.keys(NOTHING);
  assert.deepEqual([p.sent.length, p.sent.at(-1)?.v], [before + 1, 0]);
  p.wait(2000);
  const zeros = p.sent.slice(before);
  assert.equal(zeros.length, ZEROS);
  assert.ok(zeros.every(({ v, w }) => v === 0 && w === 0));
});

test("every press has a number of its own, and one press keeps its number", () => {
  const p = page();
  p.keys(FORWARD);
  p.wait(200);
  p.keys({ v: 1, w: 1 });
  p.wait(200);
  p.keys(NOTHING);
  p.wait(200);
  p.keys(FORWARD);
  const numbers = [...new Set(p.moving().map(({ press }) => press))];
  assert.deepEqual(numbers, [1, 2]);
});

test("frames are numbered upwards, from no less than the clock, and return the newest nonce", () => {
  const p = page();
  p.keys(FORWARD);
  p.wait(300);
  const numbers = p.sent.map(({ seq }) => seq);
  assert.ok(numbers.every((seq, index) => seq >= 5000 && (index === 0 || seq > (numbers[index - 1] ?? 0))));
  assert.equal(p.sent.at(-1)?.nonce, p.gate.nonce);
  assert.equal(p.sent.at(-1)?.epoch, p.gate.epoch);
});

test("after any trip a held key moves nothing until it was let go", () => {
  /** @type {Array<[string, (p: ReturnType<typeof page>) => void]>} */
  const trips = [
    ["stop", (p) => p.drive.trip("Stopped.")],
    ["the gate asks for neutral", (p) => (p.gate.needNeutral = true)],
    ["another lease", (p) => (p.gate.epoch += 1)],
    ["someone else drives", (p) => (p.permission = { may: "no", why: "Bea drives." })],
    ["nobody drives any more", (p) => (p.permission = ASK)],
  ];
  for (const [name, trip] of trips) {
    const p = page();
    p.keys(FORWARD);
    p.wait(200);
    trip(p);
    p.wait(200);
    p.gate.needNeutral = false;
    p.permission = YES;
    const before = p.moving().length;
    p.wait(2000);
    p.keys({ v: 1, w: 1 });
    p.wait(500);
    assert.equal(p.moving().length, before, name);
    assert.ok(p.drive.mustLetGo && p.drive.why, name);
    p.keys(NOTHING);
    assert.equal(p.drive.why, "", name);
    p.keys(FORWARD);
    assert.ok(p.moving().length > before, name);
  }
});

test("a page that was busy has lost touch: it does not simply go on", () => {
  const p = page();
  p.keys(FORWARD);
  p.wait(200);
  p.drive.tick(p.now + LATE_MS + PERIOD_MS + 1);
  assert.equal(p.busy, 1);
  assert.equal(p.sent.at(-1)?.v, 0);
  const before = p.moving().length;
  p.wait(1000);
  assert.equal(p.moving().length, before);
});

test("losing sight of the hands is a zero, and the same key must come down anew", () => {
  const p = page();
  p.keys(FORWARD);
  p.wait(100);
  p.drive.abandon();
  assert.equal(p.sent.at(-1)?.v, 0);
  const before = p.moving().length;
  p.wait(1000);
  assert.equal(p.moving().length, before);
  assert.ok(!p.drive.engaged);
});

test("when the gate wants neutral, a new press begins with a zero", () => {
  const p = page();
  p.gate.needNeutral = true;
  p.hear();
  p.keys(FORWARD);
  assert.deepEqual(
    p.sent.map(({ v }) => v),
    [0],
  );
  p.gate.needNeutral = false;
  p.wait(200);
  assert.ok(p.moving().length > 2);
  assert.ok(p.moving().every(({ press }) => press === p.sent[0]?.press));
});

test("a gate that keeps wanting neutral refuses the press, and the page says so", () => {
  const p = page();
  p.gate.needNeutral = true;
  p.hear();
  p.keys(FORWARD);
  p.wait(NEUTRAL_MS + 200);
  assert.ok(p.drive.mustLetGo && !p.drive.engaged);
});

test("after a trip and a lost lease the page says who drives now", () => {
  const p = page();
  p.keys(FORWARD);
  p.gate.needNeutral = true;
  p.wait(100);
  assert.equal(p.drive.why, "The safety gate stopped the robot.");
  p.permission = { may: "no", why: "Ann drives. Take over first." };
  p.wait(100);
  assert.equal(p.drive.why, "Ann drives. Take over first.");
  p.keys(NOTHING);
  assert.equal(p.drive.why, "");
});

test("when nobody drives, the press asks for control once and drives when it has it", () => {
  const p = page();
  p.permission = ASK;
  p.hear();
  p.keys(FORWARD);
  p.wait(300);
  assert.deepEqual([p.asked, p.sent.length, p.moving().length], [1, 1, 0]);
  p.permission = YES;
  p.gate.epoch += 1;
  p.wait(200);
  assert.ok(p.moving().length > 2);
  assert.ok(p.moving().every(({ epoch }) => epoch === p.gate.epoch));
});

test("a wheel that comes too late moves nothing", () => {
  const p = page();
  p.permission = ASK;
  p.hear();
  p.keys(FORWARD);
  p.wait(ASK_MS + 100);
  p.permission = YES;
  p.wait(500);
  assert.equal(p.moving().length, 0);
  assert.ok(p.drive.mustLetGo);
});

test("a key that was let go before control was granted moves nothing", () => {
  const p = page();
  p.permission = ASK;
  p.hear();
  p.keys(FORWARD);
  p.keys(NOTHING);
  p.permission = YES;
  p.wait(500);
  assert.equal(p.moving().length, 0);
});

test("without permission nothing is sent and the reason is told", () => {
  const p = page();
  p.permission = { may: "no", why: "Bea drives." };
  p.hear();
  p.keys(FORWARD);
  p.wait(500);
  assert.equal(p.sent.length, 0);
  assert.equal(p.drive.why, "Bea drives.");
});

test("presets and Shift scale the robot's own limits and never pass them", () => {
  const p = page();
  for (const [index, part] of PRESETS.entries()) {
    p.drive.preset = index + 1;
    for (const slow of [false, true]) {
      p.drive.slow = slow;
      p.keys({ v: 1, w: -1 });
      const { v, w } = p.drive.setpoint;
      assert.ok(Math.abs(v - part * 0.3 * (slow ? SLOW : 1)) < 1e-12);
      assert.ok(Math.abs(v) <= 0.3 && Math.abs(w) <= 1.5);
      p.keys(NOTHING);
    }
  }
});

test("the stronger of keys and stick counts, and both must be neutral to let go", () => {
  const p = page();
  p.drive.stick({ v: 0.3, w: 0 }, p.now);
  p.keys({ v: -1, w: 0 });
  assert.equal(p.drive.velocity.v, -1);
  p.keys(NOTHING);
  assert.ok(p.drive.engaged);
  p.drive.stick(NOTHING, p.now);
  assert.ok(!p.drive.engaged);
});
