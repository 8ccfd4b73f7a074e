// Element <fields-card>: residual vectors and projection uncertainty over the picture.

import { isNew, make, mark, write } from "../ui/element.js";
import { fixed } from "../ui/format.js";
import { t } from "../ui/texts.js";
import { isDark } from "../ui/theme.js";
import { paint } from "./coverage-card.js";
import { heatWords } from "./uncertainty-map.js";

/** @import { Calibration } from "./types.js" */

const ACROSS = 640; // canvas pixels
const TYPICAL = 16; // canvas pixels that a typical miss is drawn long

export class FieldsCard extends HTMLElement {
  #arrows = make("canvas.field", { role: "img" });
  #heat = make("canvas.field.heat", { role: "img" });
  #arrowWords = make("figcaption.note");
  #heatWords = make("figcaption.note");

  connectedCallback() {
    if (this.children.length) return;
    this.classList.add("card");
    this.append(
      make("figure", make("h2.card-title", t("fields-card.what_is_left_over")), this.#arrows, this.#arrowWords),
      make("figure", make("h2.card-title", t("fields-card.how_sure")), this.#heat, this.#heatWords),
    );
  }

  /** @param {Calibration} calibration */
  show({ solution, uncertainty, size, progress }) {
    /** @type {Array<[number, number, number, number]>} */
    const residuals = solution?.["residuals"] ?? [];
    this.hidden = !size || (!residuals.length && !uncertainty);
    if (this.hidden || !size) return;
    if (!isNew(this, residuals.length, residuals[0], progress.p95_px, isDark())) return;
    this.#arrows.style.aspectRatio = this.#heat.style.aspectRatio = `${size[0]} / ${size[1]}`;
    const longer = draw(this.#arrows, residuals, size);
    const rms = solution?.["rms_px"];
    const misses = t("fields-card.every_corner_s_miss_drawn_longer", { longer, fixed: fixed(rms ?? NaN, 2) });
    write(this.#arrowWords, t("fields-card.misses_no_pattern_should_be_seen", { misses }));
    mark(this.#arrows, "aria-label", misses);
    if (!uncertainty) return;
    const target = progress.target_px ?? 0.5;
    paint(this.#heat, uncertainty, target);
    write(this.#heatWords, `${heatWords(uncertainty, target)}.`);
  }
}

/**
 * @param {HTMLCanvasElement} canvas
 * @param {Array<[number, number, number, number]>} residuals u, v, du, dv [px]
 * @param {readonly [number, number]} size of the picture
 * @returns {number} how many times longer they are drawn
 */
function draw(canvas, residuals, [width, height]) {
  const scale = ACROSS / width;
  [canvas.width, canvas.height] = [ACROSS, Math.round(height * scale)];
  const brush = canvas.getContext("2d", { willReadFrequently: true });
  const lengths = residuals.map(([, , du, dv]) => Math.hypot(du, dv)).sort((a, b) => a - b);
  const typical = lengths[Math.floor(0.7 * lengths.length)] ?? 1;
  const longer = round(TYPICAL / Math.max(typical * scale, 1e-6));
  if (!brush) return longer;
  brush.strokeStyle = isDark() ? "#43d1e8" : "#08748a";
  brush.fillStyle = brush.strokeStyle;
  brush.lineWidth = 1.5;
  for (const [u, v, du, dv] of residuals) {
    const [x, y] = [(u + 0.5) * scale, (v + 0.5) * scale];
    brush.beginPath();
    brush.moveTo(x, y);
    brush.lineTo(x + du * scale * longer, y + dv * scale * longer);
    brush.stroke();
    brush.beginPath();
    brush.arc(x, y, 1.8, 0, 2 * Math.PI);
    brush.fill();
  }
  return longer;
}

/** To 1, 2 or 5 times a power of ten. @param {number} factor */
function round(factor) {
  const power = 10 ** Math.floor(Math.log10(Math.max(factor, 1)));
  return power * (factor / power >= 5 ? 5 : factor / power >= 2 ? 2 : 1);
}

customElements.define("fields-card", FieldsCard);
