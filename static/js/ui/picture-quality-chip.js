// Chip for the quality of the camera picture: one word and a dot; figures on a press.

import { make, mark, write } from "./element.js";
import { figures } from "./picture-quality-figures.js";
import { popover } from "./popover.js";
import { t } from "./texts.js";

/** @import { PictureQualityState as PictureQuality, State } from "../net/messages.js" */

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
  /** The chip. */
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
    write(this.#words, quality.words);
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
