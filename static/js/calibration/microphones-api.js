// HTTP client of the microphone calibration.

import { call, patiently, post } from "../net/api.js";
import { degrees } from "../ui/format.js";
import { t } from "../ui/texts.js";
import { since } from "./active-calibration.js";

/** @import { MicrophonesState as MicrophoneCalibration } from "../net/rest.js" */

const ROOT = "api/calibration/microphones";

/** @param {number} angle [rad], left is positive */
export function turned(angle) {
  const around = degrees(Math.abs(angle), 1);
  return Math.abs(angle) < 0.001
    ? around
    : `${around} ${angle > 0 ? t("microphones-api.left") : t("microphones-api.right")}`;
}

/** @param {MicrophoneCalibration["active"]} used */
export function orientationInWords(used) {
  if (!used) return t("microphones-api.in_use_the_orientation_of_the");
  const sure = t("microphones-api.turned_by_turned_degrees", {
    turned: turned(used.yaw_rad),
    degrees: degrees(2 * used.sd_yaw_rad, 1),
  });
  return t("microphones-api.in_use_sure_from_claps_claps", {
    sure,
    claps: used.claps,
    since: used.accepted_s === null ? "–" : since(used.accepted_s),
  });
}

/** @returns {Promise<MicrophoneCalibration>} */
export const read = () => call(ROOT);

/** @param {number} azimuth [rad] @param {boolean} show let the simulated person speak from there @returns {Promise<MicrophoneCalibration>} */
export async function clap(azimuth, show) {
  await post(`${ROOT}/clap`, { azimuth_rad: azimuth, show });
  return patiently(read);
}

/** @param {number} index @returns {Promise<MicrophoneCalibration>} */
export const drop = (index) => post(`${ROOT}/claps/${index}/drop`);

/** @param {"again" | "accept" | "undo"} action @returns {Promise<MicrophoneCalibration>} */
export const perform = (action) => post(`${ROOT}/${action}`);
