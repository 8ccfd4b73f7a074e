// A spoken order in words, and who may begin it.

import assert from "node:assert/strict";
import { test } from "node:test";
import { intentionOf, takesEnter } from "../../static/js/drive/keys.js";
import {
  begun,
  countdown,
  facts,
  left,
  mayBegin,
  speaker,
  title,
  whereTo,
} from "../../static/js/ui/pending-command.js";
import { STATE, VIEW } from "./view.js";

/** @type {import("../../static/js/net/messages.js").PendingCommandState} */
const INTENT = {
  id: 7,
  name: "continue",
  numbers: { distance_m: 2.5 },
  heard_as: "continue 2.5 meters",
  source: "voice",
  who: "Ada",
  begins_in_s: 1.44,
  delay_s: 2,
  target: /** @type {const} */ ("none"),
  confidence: 0.934,
  uncertain: false,
  alternatives: [],
  way: [
    [0, 0],
    [2.5, 0],
  ],
  goal: [2.5, 0],
  heading_rad: null,
  bearing_rad: null,
  bearing_sd_rad: null,
};

test("an order is told with its numbers and units", () => {
  assert.equal(title(INTENT), "Continue 2.50 m");
  assert.equal(title({ name: "stop_at", numbers: { x_m: -1, y_m: 0.5 } }), "Stop at x −1.00 m, y 0.50 m");
  assert.equal(title({ name: "turn_left", numbers: { angle_rad: Math.PI / 2 } }), "Turn left 90°");
  assert.equal(title({ name: "come_here", numbers: {} }), "Come here");
});

test("where it goes is told from where the robot stands", () => {
  const pose = { ...STATE.pose, x_m: 1, y_m: 1, heading_rad: Math.PI / 2 };
  assert.match(whereTo(INTENT, STATE.pose), /^Straight ahead, to x 2\.50 m, y 0\.00 m/);
  assert.equal(whereTo({ ...INTENT, target: "place", goal: [0, 1] }, pose), "1.00 m away, on the left");
  assert.equal(whereTo({ ...INTENT, name: "turn_left", goal: null, heading_rad: Math.PI }, pose), "On the spot, 90°");
  assert.equal(whereTo({ ...INTENT, name: "follow_wall", goal: null }, pose), "");
});

test("who is called is told with a bearing and its doubt, or that it is not known", () => {
  const come = { ...INTENT, target: /** @type {const} */ ("person"), goal: null };
  const told = whereTo({ ...come, bearing_rad: 0.61, bearing_sd_rad: 0.07 }, STATE.pose);
  assert.equal(told, "To the voice 35° to the left, ±\u00a08°");
  assert.match(whereTo({ ...come, bearing_rad: -3.1, bearing_sd_rad: 0.07 }, STATE.pose), /behind/);
  assert.match(whereTo(come, STATE.pose), /not known/);
  assert.match(speaker({ source: "ears", who: "Ada" }), /in the room, for Ada/);
});

test("a number that may be another is told first", () => {
  assert.match(facts(INTENT, STATE.pose), /^93 % certain · Straight ahead.* · Spoken by Ada$/);
  assert.match(
    facts({ ...INTENT, uncertain: true }, STATE.pose),
    /^Heard with low confidence: check the numbers · 93 % certain · Straight/,
  );
  assert.match(
    facts({ ...INTENT, uncertain: true, alternatives: ["continue 2.9 meters", "continue 2 meters"] }, STATE.pose),
    /check the numbers\. Did you mean “continue 2\.9 meters”\? · 93 % certain/,
  );
  assert.doesNotMatch(facts({ ...INTENT, alternatives: ["continue 2.9 meters"] }, STATE.pose), /Did you mean/);
  const follows = { ...INTENT, name: "follow_me", numbers: {}, uncertain: true };
  assert.match(facts(follows, STATE.pose), /^Heard with low confidence · 93 % certain/); // no numbers to check
});

test("its moment runs out", () => {
  assert.equal(countdown(INTENT), "begins in 1.4 s");
  assert.equal(left(INTENT), 0.72);
  assert.equal(left({ ...INTENT, begins_in_s: -1 }), 0);
});

test("only who drives begins it", () => {
  const view = { ...VIEW, state: { ...STATE, pending_command: INTENT } };
  assert.equal(mayBegin(view), INTENT);
  assert.equal(mayBegin({ ...view, mine: false }), null);
  assert.equal(mayBegin({ ...view, up: false }), null);
  assert.equal(mayBegin(VIEW), null);
});

test("what was spoken is told from what was typed", () => {
  const command = { ...INTENT, state: /** @type {const} */ ("running"), remark: "", progress: null };
  assert.equal(begun({ ...VIEW, state: { ...STATE, command } })?.id, 7);
  assert.equal(begun({ ...VIEW, state: { ...STATE, command: { ...command, source: "typed" } } }), null);
  assert.equal(begun({ ...VIEW, state: { ...STATE, command: { ...command, state: "done" } } }), null);
});

test("Enter begins the order that waits, and is its own elsewhere", () => {
  const enter = { code: "Enter", key: "Enter", ctrlKey: false, altKey: false, metaKey: false };
  const idle = { typing: false, singleKeys: false, waiting: true };
  assert.deepEqual(intentionOf(enter, idle), { does: "begin" });
  for (const where of [{ waiting: false }, { typing: true }, { reading: true }])
    assert.equal(intentionOf(enter, { ...idle, ...where }), null);
  assert.equal(intentionOf({ ...enter, ctrlKey: true }, idle), null);
});

test("a button to which the keyboard was led keeps its Enter, STOP always", () => {
  /** @param {boolean} led @param {boolean} stop */
  const control = (led, stop) => {
    const button = {
      matches: () => led,
      closest: (/** @type {string} */ what) => (what === "stop-button" ? stop || null : button),
    };
    return /** @type {any} */ (button);
  };
  assert.equal(takesEnter(control(true, false)), true);
  assert.equal(takesEnter(control(false, false)), false);
  assert.equal(takesEnter(control(false, true)), true);
  assert.equal(takesEnter(null), false);
});
