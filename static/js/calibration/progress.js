// Progress of a session as one number and as figures.
// Projection uncertainty as a heat map and as a sentence.

import { fixed } from "../ui/format.js";
import { t } from "../ui/texts.js";

/** @import { Calibration, Uncertainty } from "./types.js" */

const SOLVES_FROM = 4; // views
const CAMERA_VIEWS = 6; // at least
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
    return { figure: String(progress.views), goal: t("progress.of_views_views_at_least", { views: CAMERA_VIEWS }) };
  const goal = t("progress.goal_fixed_px", { fixed: fixed(progress.target_px ?? LEAST_TARGET, 2) });
  return { figure: `±${fixed(progress.p95_px, progress.p95_px < 10 ? 2 : 0)} px`, goal };
}

/** @param {number} gain 0..1 @param {number | null} [from] gain from which a direction counts as known */
export function known(gain, from) {
  if (gain >= (from ?? KNOWN)) return "known";
  return gain >= 0.4 ? "weak" : "open";
}

/** From well known to unknown; the steps double, and the goal lies between the third and the fourth. */
export const STEPS = /** @type {const} */ ([
  [24, 62, 120],
  [18, 112, 140],
  [46, 164, 138],
  [240, 200, 80],
  [236, 126, 60],
  [196, 44, 92],
]);
const GOAL_AT = 2.5; // steps

/** Where the colours begin and end, in goals. */
export const SPAN = /** @type {const} */ ([2 ** -GOAL_AT, 2 ** (STEPS.length - 1 - GOAL_AT)]);

const NOTHING = /** @type {const} */ ([88, 20, 74]);

/**
 * @param {number | null} sd [px]; null where nothing is known
 * @param {number} target [px]
 * @returns {[number, number, number]}
 */
export function heat(sd, target) {
  if (sd === null || !Number.isFinite(sd)) return [...NOTHING];
  const along = Math.min(STEPS.length - 1, Math.max(0, Math.log2(Math.max(sd, 1e-6) / target) + GOAL_AT));
  const index = Math.min(Math.floor(along), STEPS.length - 2);
  const [from, to] = [STEPS[index] ?? NOTHING, STEPS[index + 1] ?? NOTHING];
  /** @param {0 | 1 | 2} channel */
  const mix = (channel) => Math.round(from[channel] + (along - index) * (to[channel] - from[channel]));
  return [mix(0), mix(1), mix(2)];
}

/**
 * @param {Uncertainty} map
 * @param {number} target [px]
 * @returns {ImageData} one pixel a cell, to be drawn larger and smoothly
 */
export function heatPicture({ columns, rows, sd_px: sds }, target) {
  const picture = new ImageData(columns, rows);
  for (const [index, sd] of sds.flat().entries()) picture.data.set([...heat(sd, target), 255], 4 * index);
  return picture;
}

const DOWN = [t("uncertainty-map.top"), "", t("uncertainty-map.bottom")];
const ACROSS = [t("uncertainty-map.left"), "", t("uncertainty-map.right")];

/** @param {Uncertainty} map @param {number} target [px] */
export function heatWords({ sd_px: sds, rows, columns }, target) {
  const flat = sds.flat();
  const good = flat.filter((sd) => sd !== null && sd <= target).length;
  let worst = 0;
  flat.forEach((sd, index) => {
    if ((sd ?? Infinity) > (flat[worst] ?? Infinity)) worst = index;
  });
  const row = Math.floor((3 * Math.floor(worst / columns)) / rows);
  const column = Math.floor((3 * (worst % columns)) / columns);
  const where = [DOWN[row], ACROSS[column]].filter(Boolean).join(" ") || t("uncertainty-map.middle");
  return t("uncertainty-map.value_of_the_picture_within_the", {
    value: Math.round((100 * good) / Math.max(flat.length, 1)),
    where,
  });
}
