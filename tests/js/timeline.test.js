import assert from "node:assert/strict";
import { test } from "node:test";
import { noticedAt, ruler, Timeline } from "../../static/js/ui/timeline.js";
import { HELLO, STATE } from "./view.js";

/** @param {number} progress @param {object} [change] */
const at = (progress, change = {}) => ({ ...STATE, robot: { ...STATE.robot, progress }, ...change });

test("gaps are marked before the recording is played", () => {
  const line = new Timeline();
  line.begin(20, [[5, 7.5]]);
  assert.deepEqual(line.marks, [{ at: 0.25, kind: "gap", words: "No scans for 2.5 s" }]);
});

test("what was noticed is marked where it was noticed, once, and in order", () => {
  const line = new Timeline();
  line.begin(20, []);
  const notices = [
    { id: 1, stamp_s: 1, at_s: 0, level: /** @type {const} */ ("warning"), text: "The laser is silent." },
    { id: 2, stamp_s: 1, at_s: 0, level: /** @type {const} */ ("info"), text: "All is well." },
  ];
  line.saw(at(0.5, { notices }));
  line.saw(at(0.6, { notices }));
  const lost = /** @type {any} */ ({ words: "Where am I?", phase: "asking" });
  line.saw(at(0.2, { notices, floor: { ...STATE.floor, lost } }));
  line.saw(at(0.3, { notices, floor: { ...STATE.floor, lost } }));
  assert.deepEqual(
    line.marks.map((mark) => [mark.at, mark.kind]),
    [
      [0.2, "lost"],
      [0.5, "notice"],
    ],
  );
});

test("a ruler has round times and not too many", () => {
  assert.deepEqual(ruler(27, 6), [0, 5, 10, 15, 20, 25]);
  for (const duration of [0.5, 3, 59, 600, 7000, 90_000]) assert.ok(ruler(duration, 6).length <= 7);
});

test("a notice is dated by the wall clock, in a recording by its place there", () => {
  const noon = new Date(2026, 10, 30, 12, 0, 5).getTime() / 1000;
  const notice = { id: 1, stamp_s: 500_300, at_s: noon, level: /** @type {const} */ ("info"), text: "All is well." };
  assert.equal(noticedAt(notice, { hello: HELLO, state: STATE }), "12:00:05");
  const hello = { ...HELLO, robot: { ...HELLO.robot, kind: /** @type {const} */ ("LOG"), duration_s: 1200 } };
  assert.equal(noticedAt(notice, { hello, state: at(0.5, { stamp_s: 500_600 }) }), "at 5:00 of the recording");
});
