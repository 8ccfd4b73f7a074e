// Projection uncertainty as a heat map and as a sentence.

import { t } from "../ui/texts.js";

/** @import { Uncertainty } from "./types.js" */

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
