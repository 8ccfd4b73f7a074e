// Mapping of a gamepad: which button and which stick does what. Pure functions of what the browser reports.

import { t } from "../ui/texts.js";
import { response } from "./response.js";

/** @import { Velocity } from "./keys.js" */
/** @typedef {Pick<Gamepad, "index" | "id" | "mapping" | "connected" | "timestamp" | "axes" | "buttons">} Pad */
/** @typedef {-1 | 1} Sign */
/** @typedef {{button: number}} ButtonInput */
/** @typedef {{axis: number, sign: Sign, rest: -1 | 0 | 1}} AxisInput `sign`: towards which it counts; `rest`: let go */
/** @typedef {ButtonInput | AxisInput} PadInput */
/** @typedef {"deadman" | "stop" | "slow" | "slower" | "faster" | "talk"} PressAction */
/** @typedef {"forward" | "left"} StickAction */
/** @typedef {PressAction | StickAction} PadAction */
/**
 * @typedef {object} Mapping
 * @property {Readonly<Partial<Record<PadAction, PadInput>>>} inputs
 * @property {number} deadZone of every stick axis
 * @property {number} curve 0: straight, 1: cubic
 */

/** @type {readonly PressAction[]} */
export const PRESSES = ["deadman", "stop", "slow", "slower", "faster", "talk"];
/** @type {readonly StickAction[]} */
export const STICKS = ["forward", "left"];
/** @type {readonly PadAction[]} Without them a gamepad does not drive. */
export const NEEDED = ["deadman", "stop", "forward", "left"];

export const DEAD_ZONE = { least: 0.05, most: 0.4, usual: 0.12 };
export const CURVE = { least: 0, most: 1, usual: 0.4 };
const PRESSED = 0.5; // of the way of an axis that is used as a button
const BEYOND = 1.05; // an axis never reports more; a hat switch at rest does
const MOST_INPUTS = 128;

/** @type {Mapping} The W3C standard layout: left shoulder held, left stick, right face button; the upper one to talk. */
export const STANDARD = {
  inputs: {
    deadman: { button: 4 },
    stop: { button: 1 },
    slow: { button: 5 },
    slower: { button: 13 },
    faster: { button: 12 },
    talk: { button: 3 },
    forward: { axis: 1, sign: -1, rest: 0 },
    left: { axis: 0, sign: -1, rest: 0 },
  },
  deadZone: DEAD_ZONE.usual,
  curve: CURVE.usual,
};

/** @type {Mapping} A layout that nobody knows is learned by pressing: a guess could put STOP on the wrong button. */
export const UNKNOWN = { inputs: {}, deadZone: DEAD_ZONE.usual, curve: CURVE.usual };

/** @param {Pick<Pad, "mapping">} pad */
export const defaultMapping = (pad) => (pad.mapping === "standard" ? STANDARD : UNKNOWN);

/** @param {Mapping} mapping */
export const isComplete = ({ inputs }) => NEEDED.every((action) => inputs[action] !== undefined);

/**
 * How far an axis stands from its rest towards the counted side.
 * @param {Pad} pad
 * @param {AxisInput} input
 * @returns {number} −1 to 1; 0 for an axis that the gamepad does not have
 */
export function deflection(pad, { axis, sign, rest }) {
  const value = pad.axes[axis];
  if (value === undefined || !(Math.abs(value) <= BEYOND)) return 0;
  const part = ((value - rest) * sign) / (1 + Math.abs(rest));
  return Math.min(1, Math.max(-1, part));
}

/** @param {Pad} pad @param {PadInput | undefined} input */
export function isPressed(pad, input) {
  if (!input) return false;
  if ("button" in input) return pad.buttons[input.button]?.pressed === true;
  return deflection(pad, input) > PRESSED;
}

/**
 * Jog that the sticks ask for.
 * @param {Pad} pad
 * @param {Mapping} mapping
 * @returns {Velocity}
 */
export function stickVelocity(pad, { inputs, deadZone, curve }) {
  /** @param {PadInput | undefined} input */
  const part = (input) => (input && "axis" in input ? response(deflection(pad, input), deadZone, curve) : 0);
  return { v: part(inputs.forward), w: part(inputs.left) };
}

/** True for two inputs that are moved by the same press. @param {PadInput} one @param {PadInput} other */
function collide(one, other) {
  if ("button" in one) return "button" in other && one.button === other.button;
  return "axis" in other && one.axis === other.axis && one.sign === other.sign;
}

/**
 * Give an input to an action. An action that had it gets the previous input of this one, so that no needed action is
 * left without an input.
 * @param {Mapping} mapping
 * @param {PadAction} action
 * @param {PadInput} input
 * @returns {{mapping: Mapping, why: string}} the same mapping, with a sentence, when it was refused
 */
export function assign(mapping, action, input) {
  const isStick = STICKS.some((each) => each === action);
  const previous = mapping.inputs[action];
  /** @type {Partial<Record<PadAction, PadInput>>} */
  const inputs = { ...mapping.inputs, [action]: input };
  for (const other of [...PRESSES, ...STICKS]) {
    const theirs = mapping.inputs[other];
    if (other === action || !theirs) continue;
    const otherIsStick = STICKS.some((each) => each === other);
    const sameAxis = "axis" in theirs && "axis" in input && theirs.axis === input.axis;
    if (isStick !== otherIsStick && sameAxis)
      return { mapping, why: t("gamepad-mapping.that_axis_is_used_for_titles", { titles: TITLES[other] }) };
    if (!(isStick ? sameAxis : collide(theirs, input))) continue;
    if (previous) inputs[other] = previous;
    else if (NEEDED.includes(other))
      return { mapping, why: t("gamepad-mapping.that_is_used_for_titles_choose", { titles: TITLES[other] }) };
    else delete inputs[other];
  }
  return { mapping: { ...mapping, inputs }, why: "" };
}

/** @type {Readonly<Record<PadAction, string>>} */
export const TITLES = {
  deadman: t("gamepad-mapping.hold_to_drive"),
  stop: "STOP",
  slow: t("gamepad-mapping.slow_while_held"),
  slower: t("gamepad-mapping.lower_speed"),
  faster: t("gamepad-mapping.higher_speed"),
  talk: t("gamepad-mapping.talk_while_held"),
  forward: t("gamepad-mapping.forward_and_back"),
  left: t("gamepad-mapping.turn"),
};

/** A mapping as it was stored; null for a text that is none. @param {string} text @returns {Mapping | null} */
export function parseMapping(text) {
  /** @type {any} */
  let stored;
  try {
    stored = JSON.parse(text);
  } catch {
    return null;
  }
  if (typeof stored?.inputs !== "object" || stored.inputs === null) return null;
  const { deadZone, curve } = stored;
  if (!within(deadZone, DEAD_ZONE) || !within(curve, CURVE)) return null;
  /** @type {Mapping} */
  let mapping = { inputs: {}, deadZone, curve };
  for (const action of [...PRESSES, ...STICKS]) {
    const input = stored.inputs[action];
    if (input === undefined) continue;
    const parsed = parseInput(input);
    if (!parsed || (STICKS.some((each) => each === action) && "button" in parsed)) return null;
    const { mapping: next, why } = assign(mapping, action, parsed);
    if (why || Object.keys(next.inputs).length === Object.keys(mapping.inputs).length) return null;
    mapping = next;
  }
  return mapping;
}

/** @param {unknown} value @param {{least: number, most: number}} bounds */
const within = (value, { least, most }) => typeof value === "number" && value >= least && value <= most;

/** @param {any} input @returns {PadInput | null} */
function parseInput(input) {
  /** @param {unknown} value */
  const isIndex = (value) => Number.isInteger(value) && Number(value) >= 0 && Number(value) < MOST_INPUTS;
  if (isIndex(input?.button)) return { button: input.button };
  if (!isIndex(input?.axis) || ![-1, 1].includes(input.sign) || ![-1, 0, 1].includes(input.rest)) return null;
  return { axis: input.axis, sign: input.sign, rest: input.rest };
}
