// Element <verdict-line>: verdict on the newest picture, shown and announced.

import { icon, make, mark, redraw, write } from "../ui/element.js";
import { inLanguage } from "../ui/texts.js";
import { mirrored as inMirror, Pace } from "./words.js";

/** @import { Calibration } from "./types.js" */

const ICONS = /** @type {Readonly<Record<string, string>>} */ ({
  counted: "done",
  refused: "refused",
  same: "again",
  moving: "hand",
  gathering: "hand",
  background: "laser",
  nothing: "eye",
  trouble: "warning",
});

export class VerdictLine extends HTMLElement {
  #pace = new Pace();
  #icon = icon("eye");
  #words = make("p.verdict-words");
  #counted = 0;
  /** @type {string | undefined} */
  #of;

  connectedCallback() {
    if (!this.children.length) this.append(this.#icon, this.#words);
  }

  /**
   * @param {Calibration} calibration
   * @param {{mirrored: boolean, quiet: string, say: (sentence: string) => void, counted: () => void}} how `quiet`: what
   *   to say while there is no verdict; `counted` is called when a view was counted
   */
  show({ id, verdict, views, progress }, { mirrored, quiet, say, counted }) {
    if (id !== this.#of) {
      this.#of = id;
      this.#pace = new Pace();
      this.#counted = 0;
    }
    const now = performance.now();
    const shown = quiet ? null : this.#pace.show(verdict, views.length, now);
    const over = progress.ready && shown?.kind === "nothing"; // no further board is needed
    const words = over ? "" : (shown?.words ?? quiet);
    write(this.#words, inLanguage(mirrored ? inMirror(words) : words));
    redraw(this.#icon, ICONS[shown?.kind ?? ""] ?? "info");
    mark(this, "data-kind", shown?.kind ?? "quiet");
    this.hidden = words === "";
    const aloud = quiet || over ? "" : this.#pace.say(now);
    if (aloud) say(inLanguage(mirrored ? inMirror(aloud) : aloud));
    if (this.#pace.counted !== this.#counted) {
      this.#counted = this.#pace.counted;
      counted();
    }
  }
}

customElements.define("verdict-line", VerdictLine);
