// How pages start, and how a refusal reaches the operator.

import assert from "node:assert/strict";
import { existsSync, readdirSync, readFileSync } from "node:fs";
import { test } from "node:test";
import { Refusal, sentenceOf } from "../../static/js/net/api.js";
import { PAGES, pageAt } from "../../static/js/shell/pages.js";
import { FakeSocket } from "./fake-socket.js";
import { HELLO, STATE } from "./view.js";

Object.assign(globalThis, {
  addEventListener: () => {},
  document: { addEventListener: () => {}, baseURI: "http://robot/", visibilityState: "visible" },
  setInterval: () => 0,
});
const { Session } = await import("../../static/js/net/session.js");
const { AGAIN_MS, PageModel } = await import("../../static/js/ui/page-model.js");
const { fileOf } = await import("../../static/js/help/main.js");
const ROOT = new URL("../../static/", import.meta.url);

test("what is refused becomes a notice with the sentence of the server, and the caller learns of it", async () => {
  const session = new Session();
  /** @type {string[]} */
  const notices = [];
  session.on("trouble", (sentence) => notices.push(sentence));
  assert.equal(await session.attempt(async () => "done"), true);
  assert.equal(await session.attempt(() => Promise.reject(new Refusal(409, "Another operator has control."))), false);
  assert.equal(await session.attempt(() => Promise.reject("?")), false);
  assert.deepEqual(notices, ["Another operator has control.", "That did not work."]);
  assert.equal(sentenceOf(null, "The map could not be read."), "The map could not be read.");
  assert.equal(sentenceOf(new TypeError("null has no recordings")), "That did not work.");
});

test("there is one document, whose module alone creates a session, and every page of the shell is a module", async () => {
  const documents = readdirSync(ROOT).filter((name) => name.endsWith(".html"));
  // Those of `beckon fleet` and `beckon speech-quality --live --browser` are served by these commands, not by the console.
  assert.deepEqual(documents, ["fleet.html", "index.html", "speech-loop.html"]);
  const entry = /<script type="module" src="static\/([^"]*)">/.exec(
    readFileSync(new URL("index.html", ROOT), "utf8"),
  )?.[1];
  assert.match(readFileSync(new URL(entry ?? "", ROOT), "utf8"), /^startPage\(/m);
  const scripts = readdirSync(new URL("js/", ROOT), { recursive: true, encoding: "utf8" });
  const creators = scripts.filter(
    (name) => name.endsWith(".js") && readFileSync(new URL(`js/${name}`, ROOT), "utf8").includes("new Session("),
  );
  assert.deepEqual(creators, ["page.js"]);
  for (const { path, load, styles } of PAGES.filter((row) => row.path)) {
    const module = /import\("([^"]*)"\)/.exec(String(load))?.[1];
    assert.ok(module, path);
    assert.match(
      readFileSync(new URL(module, new URL("js/shell/pages.js", ROOT)), "utf8"),
      /^export function create\(/m,
      path,
    );
    for (const style of styles ?? []) assert.ok(existsSync(new URL(`css/${style}`, ROOT)), style);
  }
});

test("no tab of the console has the name of a page", () => {
  const tabs = [...readFileSync(new URL("index.html", ROOT), "utf8").matchAll(/data-tab="\w+" data-name="([^"]+)"/g)];
  assert.ok(tabs.length > 4);
  const pages = new Set(PAGES.map(({ name }) => name));
  for (const [, name] of tabs) assert.ok(!pages.has(name ?? ""), name ?? "");
});

test("an address names a page by its last part, as it always did", () => {
  /** @type {Array<[string, string | undefined]>} */
  const cases = [
    ["/", ""],
    ["/index.html", ""],
    ["/people", "people"],
    ["/people.html", "people"],
    ["/behind/a/proxy/maps", "maps"],
    ["/nothing", undefined],
    ["/people/more", undefined],
  ];
  for (const [address, path] of cases) assert.equal(pageAt(address)?.path, path, address);
});

test("a page of help is named by the hash, and nothing else can be", () => {
  assert.deepEqual(fileOf("#how-to/drive-by-voice.md#keys"), ["how-to/drive-by-voice.md", "keys"]);
  assert.deepEqual(fileOf("#docs"), ["docs", ""]);
  for (const hash of ["", "#", "#../index.html", "#//elsewhere/a.md", "#a.md?x", "#%E0"])
    assert.deepEqual(fileOf(hash), ["index.md", ""]);
});

test("a listener that comes later learns of the newest hello at once", () => {
  const session = new Session();
  /** @type {unknown[]} */
  const heard = [];
  const hear = (/** @type {unknown} */ hello) => heard.push(hello);
  session.on("hello", hear);
  assert.deepEqual(heard, []);
  session.hello = /** @type {any} */ ({ tab: "1" });
  session.on("hello", hear);
  assert.deepEqual(heard, [{ tab: "1" }]);
});

test("the camera is wanted as long as one part of the page shows it", () => {
  const session = new Session();
  /** @type {unknown[]} */
  const sent = [];
  session.link.send = (message) => sent.push(message) > 0;
  const [one, other] = [{}, {}];
  session.want(one, false);
  session.want(one, true);
  session.want(other, true);
  session.want(one, false);
  session.want(other, false);
  assert.deepEqual(
    sent.map((message) => /** @type {any} */ (message).camera),
    [false, true, false],
  );
});

test("no class is styled by two pages, or by a page and the console: all styles are of one document", () => {
  /** @type {Map<string, string>} */
  const owners = new Map();
  const sheets = readdirSync(new URL("css/", ROOT), { recursive: true, encoding: "utf8" });
  for (const sheet of sheets.filter((name) => name.endsWith(".css") && name !== "docs.css")) {
    const folder = sheet.includes("/") && !sheet.startsWith("panels/") ? sheet.slice(0, sheet.indexOf("/")) : "";
    const text = readFileSync(new URL(`css/${sheet}`, ROOT), "utf8").replace(/\/\*.*?\*\//gs, "");
    for (const [, selectors = ""] of text.matchAll(/([^{};]+)\{/g)) {
      for (const name of selectors.split(",").map((one) => one.trim())) {
        if (!/^\.[\w-]+$/.test(name)) continue;
        assert.equal(owners.get(name) ?? folder, folder, `${name} in ${sheet}`);
        owners.set(name, folder);
      }
    }
  }
  assert.ok(owners.size > 200);
});

test("a history that could not be read is read again with the next state, and a tab that is left says so", async (of) => {
  Object.assign(globalThis, { WebSocket: FakeSocket, isSecureContext: true });
  let asked = 0;
  of.mock.method(globalThis, "fetch", async (/** @type {URL} */ url) => {
    if (!String(url).includes("history")) return Response.json({ commands: [] });
    asked += 1;
    return asked === 1 ? new Response("", { status: 500 }) : Response.json({ revision: 7, commands: [{ id: 3 }] });
  });
  const session = new Session();
  session.link.open();
  const socket = /** @type {FakeSocket} */ (FakeSocket.all.at(-1));
  const lease = { ...STATE.lease, holder_id: HELLO.you.id };
  const state = { ...STATE, kind: "state", history_revision: 7, lease, command: null };
  socket.tell({ ...HELLO, kind: "hello" });
  for (let told = 0; told < 1000 && !session.history.length; told += 1) {
    socket.tell(state);
    await new Promise((resolve) => setImmediate(resolve));
  }
  assert.deepEqual([session.history.map(({ id }) => id), asked], [[3], 2]);
  of.mock.timers.enable({ apis: ["setTimeout"] });
  const leaves = () => socket.sent.some((message) => /"do":"leave"/.test(message));
  socket.tell({ ...state, route: { state: "waiting" } });
  session.suspend();
  assert.ok(!leaves(), "a route that waits at a stop goes on");
  socket.tell(state);
  session.suspend();
  assert.ok(leaves());
});

test("what a page could not read is read again while it is open, until it was read", async (context) => {
  context.mock.timers.enable({ apis: ["setTimeout"] });
  let [reads, trouble] = [0, "The console is busy."];
  class Page extends PageModel {
    /** @override */
    read() {
      return this.reading(async () => {
        reads += 1;
        if (trouble) throw new Refusal(503, trouble);
      });
    }
  }
  const page = new Page(new Session());
  const pass = async () => {
    context.mock.timers.tick(AGAIN_MS);
    for (let turn = 0; turn < 5; turn += 1) await null;
  };
  page.follow(true);
  await pass();
  await pass();
  assert.equal(page.trouble, trouble);
  assert.ok(reads > 1);
  trouble = "";
  await pass();
  assert.equal(page.trouble, "");
  const before = reads;
  await pass();
  assert.equal(reads, before);
});
