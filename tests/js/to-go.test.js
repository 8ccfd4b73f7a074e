// What is left of a command: metres of its way and seconds at its pace.

import assert from "node:assert/strict";
import test from "node:test";
import { commandSpeed, ToGo } from "../../static/js/ui/to-go.js";
import { STATE } from "./view.js";

/** @import { State } from "../../static/js/net/messages.js" */

/** @param {number} at [s] @param {number} x [m] @param {object} [change] */
const driving = (at, x, change = {}) =>
  /** @type {State} */ ({
    ...STATE,
    stamp_s: at,
    pose: { ...STATE.pose, x_m: x, y_m: 0 },
    velocity: { v_m_s: 0.2, w_rad_s: 0 },
    path: [],
    goal: { x_m: 2, y_m: 0 },
    command: { ...STATE.command, id: 7, state: "running", progress: x / 2, remark: "" },
    ...change,
  });

test("metres at once, seconds when the pace is known", () => {
  const toGo = new ToGo();
  assert.equal(toGo.saw(driving(10, 0)).join(), "2.0 m");
  assert.equal(toGo.saw(driving(12, 0.4)).join(), "1.6 m,8 s");
  assert.equal(toGo.saw(driving(14, 1.9)).join(), "0.1 m,1 s");
});

test("until it has moved for a second, the seconds are those at the speed that is set", () => {
  const toGo = new ToGo();
  const stands = { velocity: { v_m_s: 0, w_rad_s: 0 } };
  assert.equal(toGo.saw(driving(10, 0, stands), 0.2).join(), "2.0 m,10 s");
  assert.equal(toGo.saw(driving(18, 0, stands), 0.2).join(), "2.0 m,10 s"); // looking around first
  assert.equal(toGo.saw(driving(18.5, 0), 0.2).join(), "2.0 m,10 s");
  assert.equal(toGo.saw(driving(19, 0.05), 0.2).join(), "1.9 m,10 s");
  assert.equal(toGo.saw(driving(20.5, 0.4), 0.2).join(), "1.6 m,8 s");
  for (const at of [22, 23, 24]) toGo.saw(driving(at, 0.4, stands), 0.2); // something is in the way
  assert.equal(toGo.saw(driving(25, 0.4, stands), 0.2).join(), "1.6 m");
});

test("a turn on the spot at the way's end counts for no pace", () => {
  const toGo = new ToGo();
  const turns = { velocity: { v_m_s: 0, w_rad_s: 0.6 } };
  for (const at of [10, 11, 12]) toGo.saw(driving(at, 1.8 + (at - 10) * 0.05), 0.2);
  assert.equal(toGo.saw(driving(13, 1.9, turns), 0.2).join(), "0.1 m,1 s");
  assert.equal(toGo.saw(driving(15, 1.9, turns), 0.2).join(), "0.1 m,1 s");
});

test("round a corner the way counts, not the straight line", () => {
  const path = /** @type {[number, number][]} */ ([
    [0, 0],
    [0, 1],
    [2, 1],
    [2, 0],
  ]);
  assert.equal(new ToGo().saw(driving(1, 0, { path })).join(), "4.0 m");
});

test("a turn has seconds only; a command without an end, one that stands still, and none say nothing", () => {
  const turn = { goal: null, command: { ...driving(1, 0).command, progress: 0.2 } };
  const toGo = new ToGo();
  assert.equal(toGo.saw(driving(1, 0, turn)).join(), "");
  assert.equal(toGo.saw(driving(3, 0, { ...turn, command: { ...turn.command, progress: 0.6 } })).join(), "2 s");
  const endless = { command: { ...turn.command, progress: null } };
  assert.equal(toGo.saw(driving(4, 0, endless)).join(), "");
  assert.equal(toGo.saw(driving(5, 0, { command: null })).join(), "");
  const stuck = new ToGo();
  stuck.saw(driving(1, 0.5));
  assert.equal(stuck.saw(driving(3, 0.5)).join(), "1.5 m");
});

test("a command that drives has the robot's speed; a turn, the way to a person and what has ended have none", () => {
  /** @param {string} name */
  const speed = (name, state = "running") =>
    commandSpeed(driving(1, 0, { command: { ...STATE.command, name, state } }), 0.1);
  assert.deepEqual(
    ["continue", "stop_at", "follow_wall", "start"].map((name) => speed(name)),
    [0.1, 0.1, 0.1, 0.1],
  );
  assert.deepEqual(
    ["turn_left", "come_here", "follow_me"].map((name) => speed(name)),
    [null, null, null],
  );
  assert.equal(speed("continue", "done"), null);
  assert.equal(commandSpeed({ command: null }, 0.1), null);
});
