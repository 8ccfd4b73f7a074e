// Wording of a pending command: what it is, where it leads, and when it begins.

import { degrees, fixed, headingBetween, inWords, metres, quantities, whereabouts } from "./format.js";
import { t } from "./texts.js";

/** @import { CommandState, PendingCommandState, PoseState as Pose } from "../net/messages.js" */
/** @import { View } from "../net/session.js" */

export const SPOKEN = ["voice", "ears"];
const VAGUE = t("pending-command.heard_with_low_confidence");
const UNSURE = t("pending-command.heard_with_low_confidence_check_the");

/**
 * Title of a command with its numbers and units: "Continue 3.00 m".
 * @param {{name: string, numbers: Readonly<Record<string, number>>}} command
 */
export function title({ name, numbers }) {
  const words = name.replaceAll("_", " ");
  return `${words.charAt(0).toUpperCase()}${words.slice(1)} ${quantities(numbers)}`.trim();
}

/**
 * Goal relative to the robot, or direction of the voice: "2.24 m away, ahead on the left".
 * @param {PendingCommandState} pending_command
 * @param {Pose} pose
 */
export function whereTo({ target, goal, heading_rad, bearing_rad, bearing_sd_rad }, pose) {
  if (target === "person") {
    if (bearing_rad === null || bearing_sd_rad === null) return t("pending-command.the_direction_of_your_voice_is");
    return t("pending-command.to_the_voice_inwords_degrees", {
      inwords: inWords(bearing_rad),
      degrees: degrees(2 * bearing_sd_rad),
    });
  }
  if (heading_rad !== null)
    return t("pending-command.on_the_spot_degrees", {
      degrees: degrees(Math.abs(headingBetween(heading_rad, pose.heading_rad))),
    });
  if (goal === null) return "";
  const [dx, dy] = [goal[0] - pose.x_m, goal[1] - pose.y_m];
  const [cos, sin] = [Math.cos(pose.heading_rad), Math.sin(pose.heading_rad)];
  if (target !== "place")
    return t("pending-command.straight_ahead_to_x_metres_y", { metres: metres(goal[0]), metres2: metres(goal[1]) });
  return t("pending-command.metres_away_whereabouts", {
    metres: metres(Math.hypot(dx, dy)),
    whereabouts: whereabouts(cos * dx + sin * dy, cos * dy - sin * dx),
  });
}

/** Speaker, and the operator in whose name the command is executed. @param {{source: string, who: string}} command */
export const speaker = ({ source, who }) =>
  source === "ears"
    ? t("pending-command.a_voice_in_the_room_for", { who })
    : t("pending-command.spoken_by_who", { who });

/** @param {PendingCommandState} pending_command */
export const countdown = ({ begins_in_s }) =>
  t("pending-command.begins_in_fixed_s", { fixed: fixed(Math.max(begins_in_s, 0), 1) });

/**
 * What to check where the words were not certain, and the likeliest other command; "" where they were.
 * @param {PendingCommandState} pending_command
 */
const check = ({ uncertain, numbers, alternatives: [other] }) =>
  uncertain ? `${Object.keys(numbers).length ? UNSURE : VAGUE}${other ? `. Did you mean “${other}”?` : ""}` : "";

/** How sure it is of the words: "93 % certain". @param {number} confidence 0 to 1 */
export const certainty = (confidence) =>
  t("pending-command.percent_certain", { percent: Math.round(100 * confidence) });

/** Summary: low confidence, goal, speaker. @param {PendingCommandState} pending_command @param {Pose} pose */
export const facts = (pending_command, pose) =>
  [
    check(pending_command),
    certainty(pending_command.confidence),
    whereTo(pending_command, pose),
    speaker(pending_command),
  ]
    .filter(Boolean)
    .join(" · ");

/** Remaining part of the confirmation delay, 1 to 0. @param {PendingCommandState} pending_command */
export const left = ({ begins_in_s, delay_s }) => Math.min(1, Math.max(0, begins_in_s / Math.max(delay_s, 1e-3)));

/** Pending command that this page may begin now; null for none. @param {View} view */
export const mayBegin = ({ state, up, mine }) => (up && mine ? (state?.pending_command ?? null) : null);

/** Running command that was spoken. @param {View} view @returns {CommandState | null} */
export function begun({ state }) {
  const command = state?.command;
  return command?.state === "running" && SPOKEN.includes(command.source) ? command : null;
}
