// Element <verdict-line>: verdict on the newest picture, shown and announced.
// Element <advice-line>: the next view to show, and a button that asks for another suggestion.

import { icon, make, mark, redraw, write } from "../ui/element.js";
import { inLanguage, t } from "../ui/texts.js";
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

export class AdviceLine extends HTMLElement {
  #words = make("p.advice-words");
  #skip = make("button.button.plain", icon("again"), make("span", t("advice-line.another")));
  #amend = make("button.button.primary", { onclick: () => this.#counts && this.amend(this.#counts) });
  /** @type {{columns: number, rows: number} | null} */
  #counts = null;
  #of = ""; // session
  /** @type {() => void} */
  skip = () => undefined;
  /** @type {(counts: {columns: number, rows: number}) => void} */
  amend = () => undefined;

  connectedCallback() {
    if (this.children.length) return;
    this.#skip.title = t("advice-line.suggest_another_view");
    this.#skip.addEventListener("click", () => this.skip());
    this.append(make("span.advice-sign", icon("ghost")), this.#words, this.#amend, this.#skip);
    this.#amend.hidden = true;
  }

  /** @param {Calibration} calibration @param {boolean} mirrored @param {boolean} may */
  show({ id, advice, progress, kind, source, board, verdict }, mirrored, may) {
    if (id !== this.#of) [this.#of, this.#counts] = [id, null];
    const empty = kind === "laser" && (verdict === null || verdict.kind === "background") && progress.views === 0;
    const usual = progress.ready ? READY : empty && !advice ? EMPTY_ROOM : (advice?.words ?? FIRST[source]);
    this.#counts = progress.views === 0 ? (otherCounts(verdict?.words ?? "") ?? this.#counts) : null;
    this.#amend.hidden = !may || this.#counts === null;
    const seen = this.#counts && sizeOf(this.#counts);
    const words = seen ? t("advice-line.this_looks_like", { seen, entered: sizeOf(board) }) : usual;
    const advised = inLanguage(mirrored ? inMirror(words) : words);
    const missing = source === "upload" && words === advice?.words;
    write(this.#words, missing ? t("advice-line.a_picture_more_would_help", { advised }) : advised);
    if (seen) write(this.#amend, t("advice-line.use_size", { seen }));
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

/** @param {{columns: number, rows: number}} board */
const sizeOf = ({ columns, rows }) => `${columns}x${rows}`;

const READY = t("advice-line.that_is_enough_review_it_and");
const EMPTY_ROOM = t("advice-line.first_the_empty_room_step_out");

/** @type {Readonly<Record<import("./types.js").Source, string>>} */
const FIRST = {
  robot: t("advice-line.show_the_whole_board_to_the"),
  webcam: t("advice-line.show_the_whole_board_to_the"),
  upload: t("advice-line.ten_to_twenty_pictures_near_far"),
};

customElements.define("advice-line", AdviceLine);
