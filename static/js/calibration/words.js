// Wording and pacing of verdicts: left and right swapped for a mirrored picture, announced slowly enough.

import { t } from "../ui/texts.js";

/** @import { Verdict } from "./types.js" */

const CALM = new Set(["nothing", "moving", "gathering", "same", "background"]);
const STAYS_MS = 1400; // a judgement stays that long before "hold still" may take its place
const OTHER = /** @type {Readonly<Record<string, string>>} */ ({
  left: "right",
  right: "left",
  links: "rechts",
  rechts: "links",
});
const SETTLES_MS = 1600; // a calm word is spoken when it still holds after that

/** Swap left and right in words about a mirrored picture. @param {string} words */
export function mirrored(words) {
  return words.replace(/\b(left|right|links|rechts)\b/gi, (word) => {
    const other = OTHER[word.toLowerCase()] ?? word;
    return word[0] === word[0]?.toUpperCase() ? other.charAt(0).toUpperCase() + other.slice(1) : other;
  });
}

/**
 * Text in place of the verdict while nothing is judged; "" otherwise.
 * @param {Pick<import("./types.js").Calibration, "source" | "verdict" | "demo">} calibration
 * @param {{paused: boolean, blind: string, simulated: boolean}} how `blind`: why no new pictures come
 */
export function quietWords({ source, verdict, demo }, { paused, blind, simulated }) {
  if (source === "upload") return "";
  if (paused) return t("words.paused_nothing_is_taken_until_you");
  if (blind) return blind;
  if (verdict) return "";
  if (simulated && source === "robot" && !demo) return t("words.this_robot_is_simulated_press_show");
  return t("words.show_the_board_to_the_camera");
}

/** Pacing of verdicts: a judgement (counted, refused) stays although the next picture has arrived. */
export class Pace {
  /** @type {Verdict | null} */
  #shown = null;
  #since = -Infinity;
  #spoken = "";
  /** @type {number | null} */
  #views = null;
  /** Number of views counted while the page was open. */
  counted = 0;

  /**
   * @param {Verdict | null} newest only the newest arrives: one that counted a view may have been replaced on its way
   * @param {number} views that were taken so far
   * @param {number} now [ms]
   * @returns {Verdict | null}
   */
  show(newest, views, now) {
    const old = this.#shown;
    const more = this.#views !== null && views > this.#views;
    this.#views = views;
    if (more) this.counted += 1;
    const missed = more && newest && newest.kind !== "counted";
    const verdict = missed
      ? { ...newest, kind: /** @type {const} */ ("counted"), words: t("words.counted_views_now", { views }) }
      : newest;
    if (!verdict || verdict.number === old?.number) return old;
    const judged = old !== null && !CALM.has(old.kind);
    if (judged && CALM.has(verdict.kind) && now - this.#since < STAYS_MS) return old;
    if (verdict.words !== old?.words || !CALM.has(verdict.kind)) this.#since = now;
    this.#shown = verdict;
    return verdict;
  }

  /** @param {number} now [ms] @returns {string} what to say aloud now; "" for nothing */
  say(now) {
    const shown = this.#shown;
    if (!shown) return "";
    const key = CALM.has(shown.kind) ? shown.words : `${shown.number}`;
    if (key === this.#spoken || (CALM.has(shown.kind) && now - this.#since < SETTLES_MS)) return "";
    if (shown.kind === "gathering" || shown.kind === "moving") return ""; // these change too fast for speech
    this.#spoken = key;
    return shown.words;
  }
}
