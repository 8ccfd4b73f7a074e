import assert from "node:assert/strict";
import { test } from "node:test";
import { InputLearner } from "../../static/js/drive/gamepad-learning.js";
import {
  assign,
  defaultMapping,
  deflection,
  isComplete,
  isPressed,
  parseMapping,
  STANDARD,
  stickVelocity,
  UNKNOWN,
} from "../../static/js/drive/gamepad-mapping.js";
import { inputName, padName } from "../../static/js/drive/gamepad-names.js";
import { FROZEN_MS, FROZEN_ON_CHANGE_MS, GamepadReader, SETTLE_MS } from "../../static/js/drive/gamepad-reader.js";
import { response } from "../../static/js/drive/response.js";

/** @import { Mapping, Pad } from "../../static/js/drive/gamepad-mapping.js" */

const XBOX = "Xbox 360 Controller (STANDARD GAMEPAD Vendor: 045e Product: 028e)";
const [LB, B, RB, UP, DOWN] = [4, 1, 5, 12, 13];
const READ_MS = 20;
const STILL = { v: 0, w: 0 };

/** A gamepad whose buttons and axes a test moves; `stamp` is the timestamp that the browser reports. */
class TestPad {
  stamp = 1;
  /** @type {Set<number>} */
  down = new Set();

  /**
   * @param {number} [index]
   * @param {{id?: string, mapping?: GamepadMappingType, axes?: number[], buttons?: number}} [kind]
   */
  constructor(index = 0, { id = XBOX, mapping = "standard", axes = [0, 0, 0, 0], buttons = 17 } = {}) {
    Object.assign(this, { index, id, mapping });
    this.axes = axes;
    this.count = buttons;
  }

  /** @returns {Pad} */
  get pad() {
    const { index, id, mapping } = /** @type {any} */ (this);
    const buttons = Array.from({ length: this.count }, (_, button) => {
      const pressed = this.down.has(button);
      return { pressed, touched: pressed, value: pressed ? 1 : 0 };
    });
    return { index, id, mapping, connected: true, timestamp: this.stamp, axes: [...this.axes], buttons };
  }
}

/**
 * A reader with a clock of its own.
 * @param {TestPad[]} pads
 * @param {{streams?: boolean, mapping?: Mapping}} [how] `streams`: a new timestamp with every reading, as many drivers do
 */
function desk(pads, { streams = true, mapping } = {}) {
  const reader = new GamepadReader();
  let now = 1000;
  const self = {
    reader,
    pads,
    blocked: "",
    frozen: false,
    /** @returns {import("../../static/js/drive/gamepad-reader.js").Reading} the last one */
    wait(ms = READ_MS) {
      /** @type {any} */
      let reading = null;
      for (const end = now + ms; now < end; ) {
        now += READ_MS;
        if (streams && !self.frozen) for (const pad of self.pads) pad.stamp = now;
        reading = reader.read(
          self.pads.map(({ pad }) => pad),
          (pad) => mapping ?? defaultMapping(pad),
          now,
          self.blocked,
        );
      }
      return reading;
    },
    /** Something on a gamepad changes: the browser reports it with the time. @param {() => void} change */
    change(change) {
      change();
      for (const pad of self.pads) pad.stamp = now + 1;
      return self.wait();
    },
  };
  self.wait(SETTLE_MS + READ_MS);
  return self;
}

/** A gamepad that is held and pushed forward, and drives. @param {{streams?: boolean}} [how] */
function driving(how) {
  const pad = new TestPad();
  const at = desk([pad], how);
  at.change(() => pad.down.add(LB));
  const { velocity } = at.change(() => (pad.axes[1] = -1));
  assert.deepEqual(velocity, { v: 1, w: 0 });
  return { pad, at };
}

test("the response is zero in the dead zone, continuous at its edge, odd, rising and never beyond one", () => {
  for (const curve of [0, 0.4, 1]) {
    assert.equal(response(0.12, 0.12, curve), 0);
    assert.ok(response(0.121, 0.12, curve) < 0.002);
    let last = 0;
    for (let part = 0.13; part <= 1; part += 0.01) {
      const value = response(part, 0.12, curve);
      assert.ok(value > last);
      assert.equal(response(-part, 0.12, curve), -value);
      last = value;
    }
    assert.equal(response(1, 0.12, curve), 1);
    assert.equal(response(3.3, 0.12, curve), 1);
  }
  assert.equal(response(Number.NaN, 0.12), 0);
  assert.ok(response(0.5, 0.12, 1) < response(0.5, 0.12, 0) / 3);
});

test("on the standard layout forward is the left stick up and left turns left", () => {
  const pad = new TestPad();
  pad.axes = [0, -1, 0, 0];
  assert.deepEqual(stickVelocity(pad.pad, STANDARD), { v: 1, w: 0 });
  pad.axes = [-1, 0, 0, 0];
  assert.deepEqual(stickVelocity(pad.pad, STANDARD), { v: 0, w: 1 });
  pad.axes = [0.08, 0.1, 1, 1];
  assert.deepEqual(stickVelocity(pad.pad, STANDARD), STILL);
});

test("a sick axis moves nothing: absent, no number, or a hat switch at rest", () => {
  const pad = new TestPad();
  for (const axes of [[], [Number.NaN, Number.NaN], [3.28571, 3.28571], [-Infinity, Infinity]]) {
    pad.axes = axes;
    assert.deepEqual(stickVelocity(pad.pad, STANDARD), STILL);
  }
});

test("a trigger that rests at one end counts from there", () => {
  const pad = new TestPad();
  /** @type {import("../../static/js/drive/gamepad-mapping.js").AxisInput} */
  const trigger = { axis: 2, sign: 1, rest: -1 };
  for (const [value, part] of [
    [-1, 0],
    [0, 0.5],
    [1, 1],
  ]) {
    pad.axes[2] = value ?? 0;
    assert.equal(deflection(pad.pad, trigger), part);
  }
  pad.axes[2] = 0.2;
  assert.ok(isPressed(pad.pad, trigger));
  pad.axes[2] = -0.2;
  assert.ok(!isPressed(pad.pad, trigger));
});

test("nothing moves unless the deadman is held, and its release is zero with the next reading", () => {
  const pad = new TestPad();
  const at = desk([pad]);
  at.change(() => (pad.axes[1] = -1));
  assert.deepEqual(at.wait(500).velocity, STILL);
  const { at: moving, pad: held } = driving();
  assert.deepEqual(moving.change(() => held.down.delete(LB)).velocity, STILL);
});

test("a deadman that is released and pressed drives again while the stick is held", () => {
  const { at, pad } = driving();
  at.change(() => pad.down.delete(LB));
  assert.equal(at.change(() => pad.down.add(LB)).velocity.v, 1);
});

test("a gamepad that arrives with the stick pushed or the deadman down has to be let go first", () => {
  for (const arrive of [
    (/** @type {TestPad} */ pad) => (pad.axes[1] = -1),
    (/** @type {TestPad} */ pad) => pad.down.add(LB),
  ]) {
    const pad = new TestPad();
    arrive(pad);
    const at = desk([pad]);
    pad.axes[1] = -1;
    pad.down.add(LB);
    assert.deepEqual(at.wait(200).velocity, STILL);
    assert.match(at.reader.why, /Release LB and let the stick centre/);
    pad.axes[1] = 0;
    pad.down.delete(LB);
    at.wait(40);
    assert.equal(at.reader.why, "");
    pad.down.add(LB);
    pad.axes[1] = -1;
    assert.equal(at.wait(40).velocity.v, 1);
  }
});

test("after a trip the deadman has to be released and the stick centred", () => {
  const { at, pad } = driving();
  at.reader.trip("Stopped.");
  assert.deepEqual(at.wait(1000).velocity, STILL);
  assert.equal(at.reader.why, "Stopped.");
  pad.axes[1] = 0; // alone is not enough
  at.wait(40);
  pad.axes[1] = -1;
  assert.deepEqual(at.wait(40).velocity, STILL);
  pad.down.delete(LB); // nor is this, with the stick pushed
  at.wait(40);
  pad.down.add(LB);
  assert.deepEqual(at.wait(40).velocity, STILL);
  pad.down.delete(LB);
  pad.axes[1] = 0;
  at.wait(40);
  pad.down.add(LB);
  pad.axes[1] = -1;
  assert.equal(at.wait(40).velocity.v, 1);
});

test("what blocks gamepads is a zero with its reason, and they stay dead after it", () => {
  const { at } = driving();
  at.blocked = "The page does not have the focus.";
  assert.deepEqual(at.wait().velocity, STILL);
  assert.equal(at.reader.why, at.blocked);
  at.blocked = "";
  assert.deepEqual(at.wait(500).velocity, STILL);
});

test("STOP works once for each press, without the deadman, and also while gamepads are blocked", () => {
  const pad = new TestPad();
  const at = desk([pad]);
  at.blocked = "A dialog is open.";
  assert.ok(at.change(() => pad.down.add(B)).stop);
  assert.ok(!at.wait(200).stop);
  at.change(() => pad.down.delete(B));
  assert.ok(at.change(() => pad.down.add(B)).stop);
});

test("a STOP that is down when the gamepad appears stops: browsers hide it until then", () => {
  const pad = new TestPad();
  const at = desk([]);
  pad.down.add(B);
  at.pads.push(pad);
  assert.ok(at.wait().stop);
});

test("a disconnected gamepad is zero at once, and comes back at rest only", () => {
  const { at, pad } = driving();
  at.pads.length = 0;
  assert.deepEqual(at.wait().velocity, STILL);
  at.pads.push(pad);
  assert.deepEqual(at.wait(500).velocity, STILL);
});

test("a gamepad that is connected in the hand does not drive, though it looks let go at first", () => {
  const at = desk([]);
  const pad = new TestPad();
  at.pads.push(pad);
  at.wait(SETTLE_MS / 2);
  pad.down.add(LB);
  pad.axes[1] = -1;
  assert.deepEqual(at.wait(1000).velocity, STILL);
  assert.match(at.reader.why, /Release LB/);
});

test("a gamepad that repeats one timestamp while it is held is frozen, and stays so when it thaws", () => {
  const { at } = driving();
  assert.equal(at.wait(3000).velocity.v, 1); // steady, with new timestamps
  at.frozen = true;
  assert.equal(at.wait(FROZEN_MS - READ_MS).velocity.v, 1);
  assert.deepEqual(at.wait(3 * READ_MS).velocity, STILL);
  assert.match(at.reader.why, /sent nothing new. Release LB/);
  at.frozen = false;
  assert.deepEqual(at.wait(500).velocity, STILL);
});

test("a browser that reports on change only leaves a steady hand one second", () => {
  const pad = new TestPad();
  const at = desk([pad], { streams: false });
  at.wait(1000); // silent, and let go
  at.change(() => pad.down.add(LB));
  at.change(() => (pad.axes[1] = -1));
  assert.equal(at.wait(FROZEN_ON_CHANGE_MS - 2 * READ_MS).velocity.v, 1);
  assert.ok(at.change(() => (pad.axes[1] = -0.99)).velocity.v > 0.9); // a thumb is never quite still
  assert.ok(at.wait(FROZEN_ON_CHANGE_MS - 2 * READ_MS).velocity.v > 0.9);
  assert.deepEqual(at.wait(4 * READ_MS).velocity, STILL);
});

test("of two gamepads the one drives whose deadman is held; the other has to press its own afterwards", () => {
  const [one, two] = [new TestPad(0), new TestPad(1)];
  const at = desk([one, two]);
  two.down.add(LB);
  two.axes[0] = -1;
  assert.deepEqual([at.wait(40).velocity, at.reader.active], [{ v: 0, w: 1 }, 1]);
  one.down.add(LB);
  one.axes[1] = -1;
  assert.deepEqual(at.wait(40).velocity, { v: 0, w: 1 });
  two.down.delete(LB);
  assert.deepEqual(at.wait(200).velocity, STILL);
  one.down.delete(LB);
  one.axes[1] = 0;
  at.wait(40);
  one.down.add(LB);
  one.axes[1] = -1;
  assert.deepEqual(at.wait(40).velocity, { v: 1, w: 0 });
});

test("the speed buttons step once for each press, and the slow button is slow while it is held", () => {
  const { at, pad } = driving();
  assert.equal(at.change(() => pad.down.add(UP)).steps, 1);
  assert.equal(at.wait(200).steps, 0);
  assert.equal(at.change(() => pad.down.add(DOWN)).steps, -1);
  assert.equal(at.change(() => pad.down.add(RB)).slow, true);
  assert.equal(at.change(() => pad.down.delete(RB)).slow, false);
});

test("a layout that is not known does nothing until it was learned", () => {
  const pad = new TestPad(0, { mapping: "", id: "0079-0006-Generic USB Joystick" });
  const at = desk([pad]);
  for (let button = 0; button < 17; button += 1) pad.down.add(button);
  pad.axes = [-1, -1, -1, -1];
  const { velocity, stop } = at.wait(100);
  assert.deepEqual([velocity, stop, isComplete(defaultMapping(pad.pad))], [STILL, false, false]);
});

test("a mapping without STOP or without a stick does not drive, and says so", () => {
  for (const missing of /** @type {const} */ (["stop", "forward", "left"])) {
    const { [missing]: _, ...inputs } = STANDARD.inputs;
    const pad = new TestPad();
    const at = desk([pad], { mapping: { ...STANDARD, inputs } });
    at.change(() => pad.down.add(LB));
    pad.axes = [-1, -1, 0, 0];
    assert.deepEqual(at.wait(100).velocity, STILL);
    assert.match(at.reader.why, /Set this gamepad up first/);
  }
});

/**
 * Press and let go → what was learned.
 * @param {import("../../static/js/drive/gamepad-mapping.js").PadAction} action
 * @param {TestPad} pad
 * @param {() => void} press
 * @param {() => void} release
 */
function learn(action, pad, press, release) {
  const learner = new InputLearner(action);
  learner.take(pad.pad, 0);
  press();
  assert.equal(learner.take(pad.pad, 20).input, null);
  assert.equal(learner.take(pad.pad, 40).input, null);
  release();
  return learner.take(pad.pad, 60).input;
}

test("a generic gamepad is learned by pressing, and drives with what was learned", () => {
  const pad = new TestPad(0, { mapping: "", axes: [0.02, -0.01, -1, 0, 0, -1, 3.2857], buttons: 12 });
  /** @param {number} button @param {"deadman" | "stop"} action */
  const button = (button, action) =>
    learn(
      action,
      pad,
      () => pad.down.add(button),
      () => pad.down.delete(button),
    );
  /** @param {number} axis @param {number} to @param {"forward" | "left"} action */
  const stick = (axis, to, action) =>
    learn(
      action,
      pad,
      () => (pad.axes[axis] = to),
      () => (pad.axes[axis] = 0.05),
    );
  let mapping = UNKNOWN;
  for (const [action, input] of /** @type {const} */ ([
    ["deadman", button(6, "deadman")],
    ["stop", button(2, "stop")],
    ["forward", stick(1, 0.97, "forward")],
    ["left", stick(3, -1, "left")],
  ])) {
    assert.ok(input, action);
    mapping = assign(mapping, action, input).mapping;
  }
  assert.ok(isComplete(mapping));
  const at = desk([pad], { mapping });
  at.change(() => pad.down.add(6));
  assert.equal(at.change(() => (pad.axes[1] = 1)).velocity.v, 1);
  assert.equal(at.change(() => (pad.axes[3] = -1)).velocity.w, 1);
  assert.ok(at.change(() => pad.down.add(2)).stop);
});

test("a trigger axis is learned with its rest, and a button that is still down is not taken", () => {
  const pad = new TestPad(0, { mapping: "", axes: [0, 0, -1] });
  const input = learn(
    "deadman",
    pad,
    () => (pad.axes[2] = 0.9),
    () => (pad.axes[2] = -1),
  );
  assert.deepEqual(input, { axis: 2, sign: 1, rest: -1 });
  pad.down.add(3);
  const learner = new InputLearner("stop");
  for (let now = 0; now < 1000; now += READ_MS) assert.equal(learner.take(pad.pad, now).input, null);
  assert.match(learner.prompt, /Let go of every button/);
});

test("an axis that does not come back is not learned: it would be held without a hand", () => {
  const pad = new TestPad(0, { mapping: "", axes: [0, 0, 0] }); // a trigger that reads 0 until it is first moved
  const learner = new InputLearner("deadman");
  learner.take(pad.pad, 0);
  pad.axes[2] = -1;
  const answers = [20, 1000, 4000, 6000].map((now) => learner.take(pad.pad, now));
  assert.ok(answers.every(({ input }) => input === null));
  assert.ok(answers.at(-1)?.failed);
});

test("an input that was taken is swapped, so that STOP and the deadman never lose theirs", () => {
  const { mapping, why } = assign(STANDARD, "deadman", { button: B });
  assert.equal(why, "");
  assert.deepEqual([mapping.inputs.deadman, mapping.inputs.stop], [{ button: B }, { button: LB }]);
  const sticks = assign(STANDARD, "forward", { axis: 0, sign: 1, rest: 0 }).mapping;
  assert.deepEqual(sticks.inputs.left, STANDARD.inputs.forward);
  assert.match(assign(STANDARD, "slow", { axis: 0, sign: 1, rest: 0 }).why, /used for “Turn”/);
  const half = assign(UNKNOWN, "deadman", { button: 4 }).mapping;
  const refused = assign(half, "stop", { button: 4 });
  assert.deepEqual([refused.mapping, refused.why === ""], [half, false]);
});

test("a stored mapping is read back as it was, and anything else is not a mapping", () => {
  assert.deepEqual(parseMapping(JSON.stringify(STANDARD)), STANDARD);
  assert.deepEqual(parseMapping(JSON.stringify(UNKNOWN)), UNKNOWN);
  const broken = [
    "",
    "{",
    "null",
    "[]",
    '{"inputs":null,"deadZone":0.1,"curve":0}',
    JSON.stringify({ ...STANDARD, deadZone: 0 }),
    JSON.stringify({ ...STANDARD, deadZone: 1 }),
    JSON.stringify({ ...STANDARD, curve: 2 }),
    JSON.stringify({ ...STANDARD, curve: "0" }),
    JSON.stringify({ ...STANDARD, inputs: { deadman: { button: -1 } } }),
    JSON.stringify({ ...STANDARD, inputs: { deadman: { axis: 1, sign: 0, rest: 0 } } }),
    JSON.stringify({ ...STANDARD, inputs: { deadman: { button: 4 }, stop: { button: 4 } } }),
    JSON.stringify({ ...STANDARD, inputs: { deadman: { button: 4 }, slow: { button: 4 } } }),
    JSON.stringify({ ...STANDARD, inputs: { forward: { button: 12 } } }),
  ];
  for (const text of broken) assert.equal(parseMapping(text), null, text);
});

test("buttons have the names that are printed on them, and numbers where nobody knows", () => {
  const sony = "Wireless Controller (STANDARD GAMEPAD Vendor: 054c Product: 09cc)";
  /** @param {string} id @param {number} button */
  const name = (id, button, mapping = /** @type {GamepadMappingType} */ ("standard")) =>
    inputName({ id, mapping }, { button });
  assert.deepEqual([name(XBOX, LB), name(XBOX, B), name(sony, LB), name(sony, B)], ["LB", "B", "L1", "circle"]);
  assert.equal(name(sony, B, ""), "button 1");
  assert.equal(inputName({ id: "x", mapping: "" }, { axis: 2, sign: -1, rest: 0 }), "axis 2 −");
  assert.equal(padName(XBOX), "Xbox 360 Controller");
  assert.equal(padName("045e-028e-Xbox 360 Controller"), "Xbox 360 Controller");
  assert.equal(padName(""), "Gamepad");
});
