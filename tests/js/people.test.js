// The enrollment as the page knows it: what an answer that comes late may change, and when it asks again.

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
const { EnrollmentModel } = await import("../../static/js/people/enrollment-model.js");

const enrollment = { id: "1", who: "Ada", owner: "ada-1", demo: false, newest: null, advice: "", waits: "" };
const settled = () => new Promise((done) => setTimeout(done, 5));
/** @param {object | null} enrollment */
const told = (enrollment) => ({ people: [], chosen: null, enrollment, camera: true, simulated: true, stands: false });

test("an answer that comes late does not replace a newer one, and nothing is asked while one is on its way", async () => {
  const session = { hello: HELLO, on: () => {}, announce: () => {} };
  const enrollments = new EnrollmentModel(/** @type {any} */ (session));
  const beat = beats[0];
  assert.ok(beat);
  void enrollments.read();
  void enrollments.read();
  const [first, second] = open.splice(0);
  second?.(told({ ...enrollment, demo: true, waits: "for a picture" }));
  await settled();
  beat();
  assert.equal(open.length, 0, "one question is on its way still");
  first?.(told(null));
  await settled();
  assert.equal(enrollments.enrollment?.waits, "for a picture");
  beat();
  assert.equal(open.length, 1, "who shows something is watched");
  open.pop()?.(told(enrollment));
  await settled();
  beat();
  assert.equal(open.length, 0, "nobody shows anything any more");
});

test("an enrollment belongs to a user by id, not by name", async () => {
  const session = { hello: HELLO, on: () => {}, announce: () => {} };
  const enrollments = new EnrollmentModel(/** @type {any} */ (session));
  void enrollments.read();
  open.pop()?.(told(enrollment));
  await settled();
  assert.ok(enrollments.mine);
  void enrollments.read();
  open.pop()?.(told({ ...enrollment, owner: "someone else called Ada" }));
  await settled();
  assert.ok(!enrollments.mine);
});
