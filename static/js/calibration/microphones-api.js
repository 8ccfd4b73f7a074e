// The calls of the microphones' wizard.

import { call, patiently, post } from "../api.js";
import { degrees } from "../format.js";
import { since } from "./used.js";

/** @typedef {{asked_rad: number, heard_rad: number, sd_rad: number, gap_rad: number | null}} Clap */
/** @typedef {{yaw_rad: number, sd_yaw_rad: number, mirrored: boolean, residual_rad: number}} Orientation */
/**
 * @typedef {object} Bench
 * @property {boolean} microphones
 * @property {boolean} simulated
 * @property {boolean} busy
 * @property {number} listens_s how long a clap is listened for
 * @property {number[]} asked_rad where claps are asked for, one after the other
 * @property {Clap[]} claps
 * @property {string} advice
 * @property {string} verdict why the newest clap was not taken; "" when it was
 * @property {string} trouble why the newest could not be listened to; "" when it could
 * @property {string} missing why there is no solution; "" when there is
 * @property {Orientation | null} solution
 * @property {(Orientation & {claps: number, accepted_s: number, who: string}) | null} in_use
 */

const ROOT = "api/calibration/microphones";

/** @param {number} angle [rad], left is positive */
export function turned(angle) {
  const around = degrees(Math.abs(angle), 1);
  return Math.abs(angle) < 0.001 ? around : `${around} ${angle > 0 ? "left" : "right"}`;
}

/** @param {Bench["in_use"]} used */
export function orientationInWords(used) {
  if (!used) return "In use: the orientation of the array’s profile.";
  const sure = `turned by ${turned(used.yaw_rad)} ± ${degrees(2 * used.sd_yaw_rad, 1)}`;
  return `In use: ${sure}, from ${used.claps} claps, ${since(used.accepted_s)}.`;
}

/** @returns {Promise<Bench>} */
export const read = () => call(ROOT);

/** @param {number} azimuth [rad] @param {boolean} show somebody in the simulated room speaks from there @returns {Promise<Bench>} */
export async function clap(azimuth, show) {
  await post(`${ROOT}/clap`, { azimuth_rad: azimuth, show });
  return patiently(read);
}

/** @param {number} index @returns {Promise<Bench>} */
export const drop = (index) => post(`${ROOT}/claps/${index}/drop`);

/** @param {"again" | "accept" | "undo"} wish @returns {Promise<Bench>} */
export const wish = (wish) => post(`${ROOT}/${wish}`);
