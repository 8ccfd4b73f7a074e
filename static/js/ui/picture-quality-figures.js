// Wording of the picture quality figures.

import { degrees, fixed } from "./format.js";
import { t } from "./texts.js";

/** @import { CalibrationDriftState as CalibrationDrift, PictureQualityState as PictureQuality } from "../net/messages.js" */

/**
 * Rows of the panel.
 * @param {PictureQuality} quality
 * @param {CalibrationDrift | null} drift
 * @returns {[string, string][]}
 */
export function figures(quality, drift) {
  /** @type {[string, string][]} */
  const rows = [
    [
      t("picture-quality-figures.light"),
      t("picture-quality-figures.fixed_of_255_from_fixed2_to", {
        fixed: fixed(quality.mean, 0),
        fixed2: fixed(quality.low, 0),
        fixed3: fixed(quality.high, 0),
      }),
    ],
    [t("picture-quality-figures.black_white"), `${share(quality.dark_share)}, ${share(quality.bright_share)}`],
    [
      t("picture-quality-figures.noise"),
      t("picture-quality-figures.fixed_fixed2_db_below_the_light", {
        fixed: fixed(quality.noise_sd, 1),
        fixed2: fixed(quality.snr_db, 0),
      }),
    ],
    [
      t("picture-quality-figures.blur"),
      t("picture-quality-figures.pixels_across_pixels2_down", {
        pixels: pixels(quality.blur_px),
        pixels2: pixels(quality.blur_down_px),
      }),
    ],
    [
      t("picture-quality-figures.edges_stand_out"),
      t("picture-quality-figures.fixed_what_can_be_found", { fixed: fixed(quality.margin, 1) }),
    ],
    [t("picture-quality-figures.before_edges"), remedies(quality)],
  ];
  if (drift)
    rows.push([
      t("picture-quality-figures.camera_on_laser"),
      `turned ${signed(drift.apparent_rad)} ± ${degrees(drift.apparent_sd_rad, 1)}`,
    ]);
  return rows;
}

/** @param {PictureQuality} quality */
function remedies({ gain, gamma, contrast, smoothing }) {
  const done = [
    gain > 1 && `light × ${fixed(gain, 1)}`,
    gamma < 1 && t("picture-quality-figures.darks_lifted"),
    contrast !== 1 && `contrast × ${fixed(contrast, 1)}`,
    smoothing > 1 && `smoothed × ${fixed(smoothing, 1)}`,
  ].filter(Boolean);
  return done.join(", ") || t("picture-quality-figures.as_it_comes");
}

/** @param {number} part */
const share = (part) => `${fixed(100 * part, part > 0 && part < 0.01 ? 1 : 0)} %`;

/** @param {number | null} width */
const pixels = (width) => (width === null ? "–" : `${fixed(width, 1)} px`);

/** @param {number} angle */
const signed = (angle) => `${angle < 0 ? "" : "+"}${degrees(angle, 1)}`;
