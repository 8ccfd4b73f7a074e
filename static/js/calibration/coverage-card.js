// Element <known-card>: coverage of the picture, projection uncertainty, and four measures of variety.

import { isNew, make, mark, write } from "../ui/element.js";
import { fixed } from "../ui/format.js";
import { meter } from "../ui/meter.js";
import { t } from "../ui/texts.js";
import { heatPicture, heatWords, SPAN } from "./uncertainty-map.js";

/** @import { Calibration, Uncertainty } from "./types.js" */

const ENOUGH = 12; // corners in a cell until it is drawn full

const NOWHERE = Array.from({ length: 6 }, () => Array.from({ length: 8 }, () => 0));

const BARS = /** @type {const} */ ([
  ["x", t("coverage-card.left_to_right")],
  ["y", t("coverage-card.top_to_bottom")],
  ["size", t("coverage-card.near_and_far")],
  ["skew", t("coverage-card.tilted")],
]);

export class KnownCard extends HTMLElement {
  #cells = make("div.cells", { role: "img" });
  #heat = make("canvas.heat", { role: "img" });
  #waits = make("p.heat-waits.note", t("coverage-card.after_4_views"));
  #legend = make("p.inline.note", make("span"), make("span.heat-ramp"), make("span"));
  #words = make("p.note.heat-words");
  #bars = BARS.map(([key, name]) => {
    const bar = meter("div.meter", { role: "meter", "aria-label": name });
    return { key, ...bar, row: make("div.meter-row", make("span", name), bar.element) };
  });

  connectedCallback() {
    if (this.children.length) return;
    this.classList.add("card");
    this.append(
      make("h2.card-title.visually-hidden", t("coverage-card.what_the_views_cover")),
      make(
        "div.tiles",
        make("figure", this.#cells, make("figcaption", t("coverage-card.seen"))),
        make("figure", make("div.heat-box", this.#heat, this.#waits), make("figcaption", t("coverage-card.sure"))),
      ),
      this.#legend,
      this.#words,
      make("div.four-bars", ...this.#bars.map(({ row }) => row)),
    );
  }

  /** @param {Calibration} calibration */
  show({ progress, uncertainty, size }) {
    if (!isNew(this, progress.cells, progress.bars, progress.p95_px, uncertainty?.sd_px[0], size)) return;
    const shape = size ? `${size[0]} / ${size[1]}` : "4 / 3";
    this.#cells.style.aspectRatio = this.#heat.style.aspectRatio = shape;
    this.#showCells(progress.cells ?? NOWHERE);
    for (const { key, element, set } of this.#bars) {
      const part = progress.bars?.[key] ?? 0;
      set(part);
      mark(element, "data-full", part >= 1);
    }
    const target = progress.target_px ?? 0.5;
    this.#waits.hidden = uncertainty !== null;
    mark(this.#heat, "data-known", uncertainty !== null);
    this.#legend.hidden = uncertainty === null;
    write(
      /** @type {Element} */ (this.#legend.firstElementChild),
      t("coverage-card.fixed_px", { fixed: fixed(target * SPAN[0], 2) }),
    );
    write(
      /** @type {Element} */ (this.#legend.lastElementChild),
      t("coverage-card.fixed_px", { fixed: fixed(target * SPAN[1], 1) }),
    );
    write(this.#words, uncertainty ? `${heatWords(uncertainty, target)}.` : "");
    if (uncertainty) paint(this.#heat, uncertainty, target);
  }

  /** @param {number[][]} cells */
  #showCells(cells) {
    const flat = cells.flat();
    while (this.#cells.children.length < flat.length) this.#cells.append(make("span"));
    flat.forEach((count, index) => {
      const cell = /** @type {HTMLElement} */ (this.#cells.children[index]);
      cell.style.opacity = count ? String(0.3 + 0.7 * Math.min(1, count / ENOUGH)) : "";
      mark(cell, "data-seen", count > 0);
    });
    const seen = flat.filter(Boolean).length;
    mark(this.#cells, "aria-label", t("coverage-card.the_board_was_seen_in_seen", { seen, length: flat.length }));
  }
}

/** @param {HTMLCanvasElement} canvas @param {Uncertainty} map @param {number} target [px] */
export function paint(canvas, map, target) {
  const small = make("canvas");
  [small.width, small.height] = [map.columns, map.rows];
  small.getContext("2d")?.putImageData(heatPicture(map, target), 0, 0);
  [canvas.width, canvas.height] = [map.columns * 16, map.rows * 16];
  const brush = canvas.getContext("2d", { willReadFrequently: true });
  if (!brush) return;
  brush.imageSmoothingEnabled = true;
  brush.imageSmoothingQuality = "high";
  brush.drawImage(small, 0, 0, canvas.width, canvas.height);
  mark(canvas, "aria-label", heatWords(map, target));
}

customElements.define("known-card", KnownCard);
