// Element <progress-card>: present precision, goal and progress bar.

import { icon, make, mark, write } from "../ui/element.js";
import { meter } from "../ui/meter.js";
import { inLanguage, t } from "../ui/texts.js";
import { figures, share } from "./progress.js";

/** @import { Calibration } from "./types.js" */

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
