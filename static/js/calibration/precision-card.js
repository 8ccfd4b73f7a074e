// Element <gains-card>: precision of the six directions of a camera mount, and advice for the weak ones.

import { make, mark, write } from "../ui/element.js";
import { meter } from "../ui/meter.js";
import { t } from "../ui/texts.js";
import { DIRECTIONS } from "./figures.js";
import { known } from "./progress.js";

/** @import { Calibration } from "./types.js" */

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
