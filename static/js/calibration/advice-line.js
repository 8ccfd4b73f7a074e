// Element <advice-line>: the next view to show, and a button that asks for another suggestion.

import { icon, make, write } from "../ui/element.js";
import { mirrored as inMirror } from "./words.js";

/** @typedef {import("./types.js").Calibration} Calibration */

export class AdviceLine extends HTMLElement {
  #words = make("p", { class: "advice-words" });
  #skip = make("button", { type: "button", class: "button plain" }, icon("again"), make("span", {}, "Another"));
  #amend = make("button", { type: "button", class: "button primary" });
  /** @type {{columns: number, rows: number} | null} */
  #counts = null;
  /** @type {() => void} */
  skip = () => undefined;
  /** @type {(counts: {columns: number, rows: number}) => void} */
  amend = () => undefined;

  connectedCallback() {
    if (this.children.length) return;
    this.#skip.title = "Suggest another view";
    this.#skip.addEventListener("click", () => this.skip());
    this.append(make("span", { class: "advice-sign" }, icon("ghost")), this.#words, this.#amend, this.#skip);
    this.#amend.addEventListener("click", () => this.#counts && this.amend(this.#counts));
    this.#amend.hidden = true;
  }

  /**
   * @param {Calibration} calibration
   * @param {boolean} mirrored
   * @param {boolean} may
   */
  show({ advice, progress, kind, source, verdict }, mirrored, may) {
    const empty = kind === "laser" && (verdict === null || verdict.kind === "background") && progress.views === 0;
    const words = progress.ready ? READY : empty && !advice ? EMPTY_ROOM : (advice?.words ?? FIRST[source]);
    write(this.#words, mirrored ? inMirror(words) : words);
    this.#counts = progress.views === 0 ? (otherCounts(verdict?.words ?? "") ?? this.#counts) : null;
    this.#amend.hidden = !may || this.#counts === null;
    if (this.#counts) write(this.#amend, `Restart with ${this.#counts.columns} × ${this.#counts.rows}`);
    this.#skip.hidden = !may || progress.ready || !advice || source === "upload";
  }
}

/**
 * The board that the console says it sees instead of the one that was entered.
 * @param {string} words
 * @returns {{columns: number, rows: number} | null}
 */
export function otherCounts(words) {
  const found = /board with (\d+)x(\d+) inner corners, not/.exec(words);
  return found ? { columns: Number(found[1]), rows: Number(found[2]) } : null;
}

const READY = "That is enough. Review it, and use it. More views make it more exact still.";
const EMPTY_ROOM = "First the empty room: step out of the laser’s view and take the board with you.";

/** @type {Readonly<Record<import("./types.js").Source, string>>} */
const FIRST = {
  robot: "Show the whole board to the camera. The first picture shows what to do next.",
  webcam: "Show the whole board to the camera. The first picture shows what to do next.",
  upload: "Ten to twenty pictures: near, far, in every corner of the picture, and tilted every way.",
};

customElements.define("advice-line", AdviceLine);
