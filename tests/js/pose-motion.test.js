import assert from "node:assert/strict";
import { test } from "node:test";

import { PoseMotion } from "../../static/js/ui/pose-motion.js";

const DELIVERY_S = 0.05;

/** @param {PoseMotion} motion @param {number} stamp @param {number} x @param {number} heading */
const see = (motion, stamp, x, heading = 0) => motion.saw(stamp, { x, y: 0, heading }, 100 + stamp + DELIVERY_S);

test("between two frames the robot glides, and never beyond the newest", () => {
  const motion = new PoseMotion();
  for (let frame = 0; frame <= 10; frame += 1) see(motion, 0.2 * frame, 0.06 * frame);
  let before = -1;
  for (let now = 102.06; now < 102.9; now += 1 / 60) {
    const shown = motion.at(now);
    assert.ok(shown && shown.at.x >= before && shown.at.x <= 0.6 + 1e-9);
    assert.ok(before < 0 || shown.at.x - before <= (0.3 * 1.05) / 60, "no step larger than the speed");
    before = shown.at.x;
  }
  assert.equal(before.toFixed(6), "0.600000");
  assert.equal(motion.at(104)?.old, true);
});

test("a heading turns the short way round", () => {
  const motion = new PoseMotion();
  see(motion, 0, 0, 3.1);
  see(motion, 0.2, 0, -3.1);
  const shown = motion.at(100.2 + DELIVERY_S + 0.1);
  assert.ok(shown && Math.abs(Math.cos(shown.at.heading) + 1) < 0.01);
});

test("a correction of the pose is shown at once, and an older stamp begins anew", () => {
  const motion = new PoseMotion();
  see(motion, 1, 0);
  see(motion, 1.2, 4);
  assert.equal(motion.at(101.3)?.at.x, 4);
  see(motion, 0.1, 1);
  assert.equal(motion.at(100.2)?.at.x, 1);
});

test("the trail fades over half a minute", () => {
  const motion = new PoseMotion();
  for (let second = 0; second <= 60; second += 1) see(motion, second, 0.1 * second);
  const fresh = motion.trail.map((passed) => passed.fresh);
  assert.equal(fresh.length, 31);
  assert.equal(fresh[0], 0);
  assert.equal(fresh.at(-1), 1);
  assert.deepEqual(
    fresh,
    fresh.toSorted((one, other) => one - other),
  );
});
