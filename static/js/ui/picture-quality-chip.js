// Chip for the quality of the camera picture: one word and a dot; figures on a press.
// Wording of the picture quality figures.

import { make, mark, write } from "./element.js";
import { degrees, fixed, share } from "./format.js";
import { popover } from "./popover.js";
import { inLanguage, t } from "./texts.js";

/** @import { PictureQualityState as PictureQuality, State, CalibrationDriftState as CalibrationDrift } from "../net/messages.js" */

const STEADY_MS = 600; // a verdict that changes with every picture is not read
const WORDS = /** @type {const} */ ({
  good: t("picture-quality-chip.good"),
  mended: t("picture-quality-chip.mended"),
  poor: t("picture-quality-chip.poor"),
  unusable: t("picture-quality-chip.cannot_be_used"),
});

export class PictureChip {
  #dot = make("span.quality-dot");
  #text = make("span");
  #words = make("p.quality-words");
  #rows = make("dl.pairs");
  #wanted = "";
  #since = 0;
  button = make("button.quality-chip", { hidden: true }, this.#dot, this.#text);
  /** The panel that it opens over the picture. */
  panel = make(
    "div.quality",
    { role: "group", "aria-label": t("picture-quality-chip.picture_quality") },
    this.#words,
    this.#rows,
  );

  constructor() {
    popover(this.button, this.panel);
  }

  /** @param {State | null} state @param {boolean} stale true for an old picture: its quality is not reported */
  show(state, stale) {
    const quality = state?.camera?.quality ?? null;
    this.button.hidden = !quality;
    if (!quality) return;
    if (stale) this.#expire();
    else this.#judge(quality);
    if (this.panel.hidden) return;
    write(this.#words, inLanguage(quality.words));
    const rows = figures(quality, state?.calibration_drift ?? null).flat();
    while (this.#rows.children.length < rows.length) this.#rows.append(make("dt"), make("dd"));
    while (this.#rows.children.length > rows.length) this.#rows.lastElementChild?.remove();
    for (const [index, text] of rows.entries()) write(/** @type {Element} */ (this.#rows.children[index]), text);
  }

  #expire() {
    [this.#wanted, this.#since] = ["", 0];
    write(this.#text, t("picture-quality-chip.old_picture"));
    mark(this.button, "data-state", "stale");
    mark(this.button, "aria-label", t("picture-quality-chip.picture_quality_old_picture"));
  }

  /** @param {PictureQuality} quality */
  #judge({ state, label: fault }) {
    const label = t(`picture-quality-chip.${fault}`);
    const now = performance.now();
    const verdict = `${state} ${label}`;
    if (verdict !== this.#wanted) [this.#wanted, this.#since] = [verdict, this.#wanted ? now : 0];
    if (this.#text.textContent && now - this.#since < STEADY_MS) return;
    write(
      this.#text,
      state === "unusable" ? t("picture-quality-chip.unusable") : label.replace(/^./, (letter) => letter.toUpperCase()),
    );
    mark(this.button, "data-state", state);
    mark(
      this.button,
      "aria-label",
      t("picture-quality-chip.picture_quality_label_words", { label, words: WORDS[state] }),
    );
  }
}

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

/** @param {number | null} width */
const pixels = (width) => (width === null ? "–" : `${fixed(width, 1)} px`);

/** @param {number} angle */
const signed = (angle) => `${angle < 0 ? "" : "+"}${degrees(angle, 1)}`;
