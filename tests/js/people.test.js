// The lesson as the page knows it: what an answer that comes late may change, and when it asks again.

import assert from "node:assert/strict";
import { test } from "node:test";
import { HELLO } from "./view.js";

/** @type {((told: object) => void)[]} questions that are not answered yet, the oldest first */
const open = [];
/** @type {(() => void)[]} */
const beats = [];
Object.assign(globalThis, {
  document: { baseURI: "http://robot/", visibilityState: "visible", addEventListener: () => {} },
  fetch: () => new Promise((answer) => open.push((told) => answer({ ok: true, json: async () => told }))),
  setInterval: (/** @type {() => void} */ beat) => beats.push(beat),
});
const { Lessons } = await import("../../static/js/people/lessons.js");

const lesson = { id: "1", who: "Ada", owner: "ada-1", showing: false, newest: null, advice: "", waits: "" };
const settled = () => new Promise((done) => setTimeout(done, 5));
/** @param {object | null} enrolment */
const told = (enrolment) => ({ people: [], chosen: null, enrolment, camera: true, simulated: true, stands: false });

test("an answer that comes late does not replace a newer one, and nothing is asked while one is on its way", async () => {
  const session = { hello: HELLO, on: () => {}, announce: () => {} };
  const lessons = new Lessons(/** @type {any} */ (session));
  const beat = beats[0];
  assert.ok(beat);
  void lessons.read();
  void lessons.read();
  const [first, second] = open.splice(0);
  second?.(told({ ...lesson, showing: true, waits: "for a picture" }));
  await settled();
  beat();
  assert.equal(open.length, 0, "one question is on its way still");
  first?.(told(null));
  await settled();
  assert.equal(lessons.enrolment?.waits, "for a picture");
  beat();
  assert.equal(open.length, 1, "who shows something is watched");
  open.pop()?.(told(lesson));
  await settled();
  beat();
  assert.equal(open.length, 0, "nobody shows anything any more");
});

test("a lesson is one's own by who one is, not by the name", async () => {
  const session = { hello: HELLO, on: () => {}, announce: () => {} };
  const lessons = new Lessons(/** @type {any} */ (session));
  void lessons.read();
  open.pop()?.(told(lesson));
  await settled();
  assert.ok(lessons.mine);
  void lessons.read();
  open.pop()?.(told({ ...lesson, owner: "somebody else called Ada" }));
  await settled();
  assert.ok(!lessons.mine);
});
