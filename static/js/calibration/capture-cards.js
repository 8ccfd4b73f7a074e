// Element <progress-card>: present precision, goal and progress bar.
// Element <uploads-card>: result of each uploaded file.
// Element <empty-stage>: the reason why there is no picture, and a button that helps.
// Element <camera-choice>: select one of several cameras of this device.
// Element <known-card>: coverage of the picture, projection uncertainty, and four measures of variety.
// Element <gains-card>: precision of the six directions of a camera mount, and advice for the weak ones.

import { icon, isNew, make, mark, write } from "../ui/element.js";
import { fixed } from "../ui/format.js";
import { remember, remembered } from "../ui/local-storage.js";
import { meter } from "../ui/meter.js";
import { inLanguage, t } from "../ui/texts.js";
import { DIRECTIONS } from "./figures.js";
import { figures, heatPicture, heatWords, known, SPAN, share } from "./progress.js";
import { grouped } from "./uploads.js";

/** @import { Calibration, Uncertainty } from "./types.js" */
/** @import { Uploads } from "./uploads.js" */
/** @import { Webcam } from "./webcam.js" */

export class ProgressCard extends HTMLElement {
  #figure = make("span.progress-figure");
  #goal = make("span.progress-goal");
  #bar = meter("div.meter.progress-bar", { role: "progressbar", "aria-label": t("progress-card.how_far") });
  #words = make("p.progress-words");
  #solving = make("p.progress-solving.note", icon("running"), make("span"));
  #title = make("h2.card-title");

  connectedCallback() {
    if (this.children.length) return;
    this.classList.add("card");
    this.append(
      make("div.progress-head", this.#title, this.#solving),
      make("p.progress-figures", this.#figure, this.#goal),
      this.#bar.element,
      this.#words,
    );
  }

  /** @param {Calibration} calibration */
  show(calibration) {
    const { progress, solving, kind } = calibration;
    const { figure, goal } = figures(calibration);
    write(this.#title, kind === "camera" ? t("progress-card.how_exact") : t("progress-card.how_far"));
    write(this.#figure, figure);
    write(this.#goal, goal);
    write(this.#words, inLanguage(progress.words));
    this.#bar.set(share(calibration));
    mark(this.#bar.element, "aria-valuetext", inLanguage(progress.words));
    mark(this, "data-ready", progress.ready);
    mark(this.#solving, "data-on", solving !== null);
    write(/** @type {Element} */ (this.#solving.lastElementChild), solving ? inLanguage(solving.words) : "");
  }
}

customElements.define("progress-card", ProgressCard);

const NAMED_FILES = 3; // of a row; more are counted

const ICONS = /** @type {Readonly<Record<string, string>>} */ ({ counted: "done", same: "again", nothing: "eye" });

export class UploadsCard extends HTMLElement {
  #title = make("h2.card-title");
  #list = make("ul.attempts");

  connectedCallback() {
    if (this.children.length) return;
    this.classList.add("card");
    this.append(make("div.card-head", this.#title), this.#list);
  }

  /** @param {Uploads} uploads */
  show({ attempts, waiting }) {
    this.hidden = attempts.length + waiting === 0;
    if (!isNew(this, attempts.length, waiting)) return;
    const taken = attempts.filter(({ kind }) => kind === "counted").length;
    write(
      this.#title,
      waiting
        ? t("uploads-card.waiting_filevalue_to_go", { waiting, value: waiting === 1 ? "" : "s" })
        : t("uploads-card.taken_of_length_files_counted", { taken, length: attempts.length }),
    );
    this.#list.replaceChildren(
      ...grouped(attempts).map(({ names, kind, words }) =>
        make(
          "li.attempt",
          { "data-kind": kind },
          icon(ICONS[kind] ?? "refused"),
          make(
            "span",
            make("span.attempt-name", { title: names.join(", ") }, namesIn(names)),
            kind === "counted" ? null : make("span.note", inLanguage(words)),
          ),
        ),
      ),
    );
  }
}

/** @param {string[]} names newest first */
function namesIn(names) {
  const more = names.length - NAMED_FILES;
  const named = names.slice(0, NAMED_FILES).join(", ");
  return more > 0 ? t("uploads-card.names_and_more", { named, more }) : named;
}

customElements.define("uploads-card", UploadsCard);

export class EmptyStage extends HTMLElement {
  #words = make("p");
  #button = make("button.button.primary.large", { onclick: () => this.pressed() });
  /** @type {() => void} */
  pressed = () => undefined;

  connectedCallback() {
    if (this.children.length) return;
    this.append(this.#words, this.#button);
  }

  /**
   * @param {string} why there is no picture; "" when there is one
   * @param {string} offer what the button says; "" for none
   */
  show(why, offer) {
    this.hidden = why === "";
    write(this.#words, why);
    this.#button.hidden = offer === "";
    write(this.#button, offer);
  }
}

customElements.define("empty-stage", EmptyStage);

export class CameraChoice extends HTMLElement {
  #select = make("select.field-box", { "aria-label": t("camera-choice.which_camera") });
  /** @type {() => void} */
  changed = () => undefined;

  connectedCallback() {
    if (this.children.length) return;
    this.hidden = true;
    this.append(this.#select);
    this.#select.addEventListener("change", () => {
      remember("webcam", this.#select.value);
      this.changed();
    });
  }

  get chosen() {
    return remembered("webcam", "") || undefined;
  }

  /** @param {Webcam} webcam */
  async show(webcam) {
    const choices = await webcam.choices();
    this.hidden = choices.length < 2;
    this.#select.replaceChildren(...choices.map(({ id, name }) => make("option", { value: id }, name)));
    this.#select.value = choices.find(({ id }) => id === this.chosen)?.id ?? choices[0]?.id ?? "";
  }
}

customElements.define("camera-choice", CameraChoice);

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

const WORDS = { known: "known", weak: t("precision-card.not_quite"), open: "open" };

export class GainsCard extends HTMLElement {
  #bars = Object.entries(DIRECTIONS).map(([key, [name, says]]) => ({ key, ...gainBar(name, says) }));
  #weak = make("ul.weak");
  #offset = make("p.laser-offset");

  connectedCallback() {
    if (this.children.length) return;
    this.classList.add("card");
    this.append(
      make("h2.card-title", t("precision-card.six_directions")),
      make("div.precision", ...this.#bars.map(({ row }) => row)),
      this.#offset,
      this.#weak,
    );
  }

  /** @param {Calibration} calibration */
  show({ progress }) {
    const [precision, weak, landing] = [progress.precision ?? {}, progress.weak ?? [], progress.laser_offset ?? ""];
    for (const { key, row, element, set, word } of this.#bars) {
      const gain = Math.max(0, precision[key] ?? 0);
      set(gain);
      const measured = progress.from_ruler?.[key];
      const state = measured ? "known" : known(gain, progress.known_from);
      mark(element, "data-full", state === "known");
      mark(row, "data-known", state);
      write(word, measured ?? WORDS[state]);
    }
    write(this.#offset, landing);
    this.#offset.hidden = landing === "";
    if ([...this.#weak.children].map((item) => item.textContent).join() === weak.join()) return;
    this.#weak.replaceChildren(...weak.map((sentence) => make("li", sentence)));
  }
}

/** @param {string} name @param {string} says */
function gainBar(name, says) {
  const bar = meter("div.meter.gain", { role: "meter", "aria-label": `${name}: ${says}` });
  const word = make("span.note.gain-word");
  const head = make("div.gain-head", make("span.gain-name", name), word);
  return { ...bar, word, row: make("div.gain-row", { title: says }, head, bar.element, make("span.note", says)) };
}

customElements.define("gains-card", GainsCard);
