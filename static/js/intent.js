// A spoken order in words: what it is, where it goes, who is called, and when it begins.

import { degrees, fixed, headingBetween, inWords, metres, quantities, whereabouts } from "./format.js";

/** @typedef {import("./wire.js").IntentState} IntentState */
/** @typedef {import("./wire.js").CommandState} CommandState */
/** @typedef {import("./wire.js").Pose} Pose */
/** @typedef {import("./session.js").View} View */

const TO_A_PERSON = ["come_here", "follow_me"];
const SPOKEN = ["voice", "ears"];
const UNSURE = "Not heard for sure: check the numbers";

/**
 * The order with its numbers and units: "Continue 3.00 m".
 * @param {{name: string, numbers: Readonly<Record<string, number>>}} order
 */
export function title({ name, numbers }) {
  const words = name.replaceAll("_", " ");
  return `${words.charAt(0).toUpperCase()}${words.slice(1)} ${quantities(numbers)}`.trim();
}

/**
 * Where it would go from where the robot stands, or who is called: "2.24 m away, ahead on the left".
 * @param {IntentState} intent
 * @param {Pose} pose
 */
export function whither({ name, goal, heading_rad, bearing_rad, bearing_sd_rad }, pose) {
  if (TO_A_PERSON.includes(name)) {
    if (bearing_rad === null || bearing_sd_rad === null) return "From where you speak is not known";
    return `To the voice ${inWords(bearing_rad)}, ± ${degrees(2 * bearing_sd_rad)}`;
  }
  if (heading_rad !== null) return `On the spot, ${degrees(Math.abs(headingBetween(heading_rad, pose.heading_rad)))}`;
  if (goal === null) return "";
  const [dx, dy] = [goal[0] - pose.x_m, goal[1] - pose.y_m];
  const [cos, sin] = [Math.cos(pose.heading_rad), Math.sin(pose.heading_rad)];
  if (name === "continue") return `Straight ahead, to x ${metres(goal[0])}, y ${metres(goal[1])} of the map`;
  return `${metres(Math.hypot(dx, dy))} away, ${whereabouts(cos * dx + sin * dy, cos * dy - sin * dx)}`;
}

/**
 * Who spoke, and in whose name it is done.
 * @param {{source: string, who: string}} order
 */
export const speaker = ({ source, who }) =>
  source === "ears" ? `A voice in the room, for ${who}` : `Spoken by ${who}`;

/** @param {IntentState} intent */
export const countdown = ({ begins_in_s }) => `begins in ${fixed(Math.max(begins_in_s, 0), 1)} s`;

/**
 * What is to be known of it at a glance: a number that may be another, where it goes, who spoke.
 * @param {IntentState} intent
 * @param {Pose} pose
 */
export const facts = (intent, pose) =>
  [intent.unsure ? UNSURE : "", whither(intent, pose), speaker(intent)].filter(Boolean).join(" · ");

/**
 * How much of its moment is left, 1 to 0.
 * @param {IntentState} intent
 */
export const left = ({ begins_in_s, moment_s }) => Math.min(1, Math.max(0, begins_in_s / Math.max(moment_s, 1e-3)));

/**
 * The order that waits and that this page may begin at once; null where there is none.
 * @param {View} view
 */
export const mayBegin = ({ state, up, mine }) => (up && mine ? (state?.intent ?? null) : null);

/**
 * What is being done because somebody said it.
 * @param {View} view
 * @returns {CommandState | null}
 */
export function begun({ state }) {
  const command = state?.command;
  return command?.state === "running" && SPOKEN.includes(command.source) ? command : null;
}
