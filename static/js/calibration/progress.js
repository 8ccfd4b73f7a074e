// Progress of a session as one number and as figures.

import { fixed } from "../ui/format.js";
import { t } from "../ui/texts.js";

/** @import { Calibration } from "./types.js" */

const SOLVES_FROM = 4; // views
const LEAST_TARGET = 0.5; // [px]
const FIRST = 0.3; // share of the way that is done when the first solution is there
const ROUGH = 16; // a first solution is that many times worse than wanted
const KNOWN = 0.7; // gain from which a direction counts as known, until the console has said it
export const LASER_POSES = 10;

/** @param {Calibration} calibration @returns {number} 0..1, and 1 only when it is good enough */
export function share({ kind, progress }) {
  if (progress.ready) return 1;
  const { views, p95_px: p95 } = progress;
  if (kind === "camera") {
    if (typeof p95 !== "number") return (FIRST * Math.min(views, SOLVES_FROM)) / SOLVES_FROM;
    const left = Math.log(Math.max(p95 / (progress.target_px ?? LEAST_TARGET), 1)) / Math.log(ROUGH);
    return Math.min(0.98, FIRST + (1 - FIRST) * Math.max(0, 1 - left));
  }
  const [from, from_ruler] = [progress.known_from ?? KNOWN, progress.from_ruler ?? {}];
  const precision = Object.entries(progress.precision ?? {}).map(([name, gain]) => (name in from_ruler ? from : gain));
  const known = precision.reduce((sum, gain) => sum + Math.min(1, Math.max(0, gain) / from), 0) / 6;
  return Math.min(0.98, 0.4 * Math.min(1, views / LASER_POSES) + 0.6 * known);
}

/** Figure and goal next to the bar. @param {Calibration} calibration @returns {{figure: string, goal: string}} */
export function figures({ kind, progress }) {
  if (kind === "laser")
    return {
      figure: String(progress.views),
      goal: t("progress.of_laserposes_poses_at_least", { laserposes: LASER_POSES }),
    };
  if (typeof progress.p95_px !== "number")
    return {
      figure: `${Math.min(progress.views, SOLVES_FROM)}/${SOLVES_FROM}`,
      goal: t("progress.views_to_the_first_figure"),
    };
  const goal = t("progress.goal_fixed_px", { fixed: fixed(progress.target_px ?? LEAST_TARGET, 2) });
  return { figure: `±${fixed(progress.p95_px, progress.p95_px < 10 ? 2 : 0)} px`, goal };
}

/** @param {number} gain 0..1 @param {number | null} [from] gain from which a direction counts as known */
export function known(gain, from) {
  if (gain >= (from ?? KNOWN)) return "known";
  return gain >= 0.4 ? "weak" : "open";
}
