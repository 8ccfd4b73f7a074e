// Format calibration values with two significant digits of their standard deviation.

import { fixed } from "../ui/format.js";
import { inLanguage, t } from "../ui/texts.js";

/**
 * @typedef {object} ValueRow
 * @property {string} key as the server names it
 * @property {string} name as the paper's Table 3 names it, and as sentences and files do
 * @property {string} says what it is
 * @property {string} value
 * @property {string} sd
 * @property {string} other in use now, "" where there is none
 * @property {string} change "" where there is nothing to compare
 * @property {boolean} [open] nothing is known of it
 * @property {boolean} far the two differ by more than three standard deviations
 */

const MOST_DECIMALS = 5;

/** @type {ReadonlyArray<readonly [string, string, string]>} */
const CAMERA = [
  ["fx", "fᵤ (fx)", t("figures.focal_length_across")],
  ["fy", "fᵥ (fy)", t("figures.focal_length_down")],
  ["cx", "u₀ (cx)", t("figures.centre_across")],
  ["cy", "v₀ (cy)", t("figures.centre_down")],
  ["k1", "k₁", t("figures.radial_square")],
  ["k2", "k₂", t("figures.radial_4th_power")],
  ["p1", "p₁", t("figures.tangential")],
  ["p2", "p₂", t("figures.tangential")],
  ["k3", "k₃", t("figures.radial_6th_power")],
];

/** How many decimals show two digits of a standard deviation. @param {number} sd */
export function decimals(sd) {
  if (!(sd > 0) || !Number.isFinite(sd)) return 4;
  return Math.min(MOST_DECIMALS, Math.max(0, 1 - Math.floor(Math.log10(sd))));
}

/**
 * Table 3 of the paper: a row for each parameter that was estimated.
 * @param {Record<string, any>} solution
 * @param {Record<string, [number, number]> | null} compare name → now, in use
 * @returns {ValueRow[]}
 */
export function cameraRows(solution, compare) {
  /** @type {Record<string, number>} */
  const sds = solution["sd"] ?? {};
  return CAMERA.filter(([key]) => typeof solution[key] === "number").map(([key, name, says]) => {
    const sd = sds[key] ?? NaN;
    return row({ key, name, says, value: solution[key], sd, unit: "", other: compare?.[key]?.[1] });
  });
}

/** @type {Readonly<Record<string, readonly [string, string]>>} */
export const DIRECTIONS = {
  roll: [t("figures.roll"), t("figures.turned_about_the_line_of_sight")],
  pitch: [t("figures.pitch"), t("figures.looking_up_or_down")],
  yaw: [t("figures.yaw"), t("figures.looking_left_or_right")],
  forward: [t("figures.forward"), t("figures.in_front_of_the_laser")],
  sideways: [t("figures.sideways"), t("figures.to_the_left_of_the_laser")],
  height: [t("figures.height"), t("figures.above_the_laser")],
};

/** The six of a mount as the comparison with the one in use names them: [deg], [m]. */
const IN_USE = ["roll_deg", "pitch_deg", "yaw_deg", "x_m", "y_m", "z_m"];

/**
 * Turns [deg] and shifts [mm] of the camera on the laser; unobservable ones are marked "not known".
 * @param {Record<string, any>} solution
 * @param {Record<string, [number, number]> | null} compare
 * @returns {ValueRow[]}
 */
export function mountRows(solution, compare) {
  /** @type {number[]} */
  const turns = solution["turn_deg"] ?? [];
  /** @type {number[]} */
  const shifts = solution["translation_m"] ?? [];
  /** @type {string[]} */
  const open = solution["not_known"] ?? [];
  return Object.entries(DIRECTIONS).map(([key, [name, says]], index) => {
    const turned = index < 3;
    const value = turned ? (turns[index] ?? NaN) : 1e3 * (shifts[index - 3] ?? NaN);
    const sd = turned ? solution["sd_rotation_deg"]?.[index] : 1e3 * (solution["sd_translation_m"]?.[index - 3] ?? NaN);
    const active = compare?.[IN_USE[index] ?? ""]?.[1];
    const other = active === undefined || turned ? active : 1e3 * active;
    const unit = turned ? "°" : " mm";
    if (!open.includes(key)) return row({ key, name, says, value, sd, unit, other });
    return { key, name, says, value: t("figures.not_known"), sd: "", other: "", change: "", open: true, far: false };
  });
}

/**
 * @param {{key: string, name: string, says: string, value: number, sd: number, unit: string, other: number | undefined}} parameter
 * @returns {ValueRow}
 */
function row({ key, name, says, value, sd, unit, other }) {
  const digits = decimals(sd);
  const compared = other !== undefined && Number.isFinite(other);
  const change = compared ? value - other : 0;
  return {
    key,
    name,
    says,
    value: `${fixed(value, digits)}${unit}`,
    sd: `± ${fixed(sd, digits)}${unit}`,
    other: compared ? `${fixed(other, digits)}${unit}` : "",
    change: compared ? `${change > 0 && Number(change.toFixed(digits)) ? "+" : ""}${fixed(change, digits)}` : "",
    far: compared && Math.abs(change) > 3 * sd,
  };
}

/** @typedef {{rvec_rad: number[], tvec_m: number[], sd_rotation_rad: number[], sd_translation_m: number[]}} BoardPose */

/**
 * Name, place and turn of every view that takes part, each number ± its standard deviation.
 * @param {Array<{image: string, used: boolean, pose?: BoardPose}>} views
 * @returns {[string, string, string][]}
 */
export function poseRows(views) {
  return views.flatMap(({ image, used, pose }) =>
    used && pose
      ? [
          [
            inLanguage(image),
            listed(pose.tvec_m, pose.sd_translation_m, 1e3),
            listed(pose.rvec_rad, pose.sd_rotation_rad, 180 / Math.PI),
          ],
        ]
      : [],
  );
}

/** @param {number[]} values @param {number[]} sds @param {number} unit of the values shown */
const listed = (values, sds, unit) =>
  values
    .map((value, axis) => `${fixed(unit * value, 1)}\u00a0±\u00a0${fixed(unit * (sds[axis] ?? NaN), 2)}`)
    .join(", ");
