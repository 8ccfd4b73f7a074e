// Wording of the picture quality figures.

import { degrees, fixed } from "./format.js";

/** @typedef {import("../net/messages.js").PictureQualityState} PictureQuality */
/** @typedef {import("../net/messages.js").CalibrationDriftState} CalibrationDrift */

/**
 * Rows of the panel.
 * @param {PictureQuality} quality
 * @param {CalibrationDrift | null} drift
 * @returns {[string, string][]}
 */
export function figures(quality, drift) {
  /** @type {[string, string][]} */
  const rows = [
    ["Light", `${fixed(quality.mean, 0)} of 255, from ${fixed(quality.low, 0)} to ${fixed(quality.high, 0)}`],
    ["Black, white", `${share(quality.dark_share)}, ${share(quality.bright_share)}`],
    ["Noise", `${fixed(quality.noise_sd, 1)}, ${fixed(quality.snr_db, 0)} dB below the light`],
    ["Blur", `${pixels(quality.blur_px)} across, ${pixels(quality.blur_down_px)} down`],
    ["Edges stand out", `${fixed(quality.margin, 1)} × what can be found`],
    ["Before edges", remedies(quality)],
  ];
  if (drift)
    rows.push(["Camera on laser", `turned ${signed(drift.apparent_rad)} ± ${degrees(drift.apparent_sd_rad, 1)}`]);
  return rows;
}

/** @param {PictureQuality} quality */
function remedies({ gain, gamma, contrast, smoothing }) {
  const done = [
    gain > 1 && `light × ${fixed(gain, 1)}`,
    gamma < 1 && `darks lifted`,
    contrast !== 1 && `contrast × ${fixed(contrast, 1)}`,
    smoothing > 1 && `smoothed × ${fixed(smoothing, 1)}`,
  ].filter(Boolean);
  return done.join(", ") || "as it comes";
}

/** @param {number} part */
const share = (part) => `${fixed(100 * part, part > 0 && part < 0.01 ? 1 : 0)} %`;

/** @param {number | null} width */
const pixels = (width) => (width === null ? "–" : `${fixed(width, 1)} px`);

/** @param {number} angle */
const signed = (angle) => `${angle < 0 ? "" : "+"}${degrees(angle, 1)}`;
