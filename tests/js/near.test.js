// Who was near in the last minute.

import assert from "node:assert/strict";
import { test } from "node:test";
import { Near } from "../../static/js/ui/near.js";

const pose = { x_m: 0, y_m: 0, heading_rad: 0 };
/** @param {number} stamp_s @param {object[]} voices @param {object | null} person @returns {any} */
const state = (stamp_s, voices, person = null) => ({ stamp_s, pose, ears: { voices }, person });
/** @param {number} azimuth_world_rad @param {number} age_s */
const voice = (azimuth_world_rad, age_s) => ({ azimuth_world_rad, age_s });

test("a voice is remembered for a minute, and one from there again is the same", () => {
  const near = new Near();
  assert.equal(near.saw(state(10, [voice(0.5, 0)])).length, 1);
  const [again, ...others] = near.saw(state(30, [voice(0.55, 1)]));
  assert.deepEqual(others, []);
  assert.ok(again && again.azimuth === 0.55 && again.age === 1);
  assert.equal(near.saw(state(88, [])).length, 1);
  assert.deepEqual(near.saw(state(90, [])), []);
});

test("who was seen is where they stood, however the robot moves", () => {
  const near = new Near();
  near.saw(state(10, [], { x_m: 2, y_m: 0, age_s: 0 }));
  const moved = { ...state(12, []), pose: { x_m: 2, y_m: -1, heading_rad: Math.PI / 2 } };
  const [one] = near.saw(moved);
  assert.ok(one?.seen && Math.abs(one.azimuth) < 1e-9 && one.age === 2);
  assert.ok(Math.abs((near.towards(one.id) ?? 0) - Math.PI / 2) < 1e-9);
});

test("a clock that begins again forgets everybody", () => {
  const near = new Near();
  near.saw(state(100, [voice(1, 0)]));
  assert.deepEqual(near.saw(state(3, [])), []);
});
