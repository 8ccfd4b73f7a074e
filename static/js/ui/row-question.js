// A question in a row of a list, which asks one at a time.

import { make } from "./element.js";
import { t } from "./texts.js";

/**
 * A place for it.
 * @template {"div" | "form"} T
 * @param {HTMLElement} row
 * @param {T} tag
 * @param {Record<string, any>} more attributes
 */
export function questionIn(row, tag, more) {
  for (const other of row.parentElement?.querySelectorAll(".map-question") ?? []) other.remove();
  const question = make(tag, { class: "row map-question", ...more });
  row.append(question);
  return question;
}

/**
 * Ask whether something is to be done.
 * @param {HTMLElement} row
 * @param {string} sentence
 * @param {string} does what the button says that does it
 * @param {() => void} act
 * @param {() => void} [stay] done where it is left
 */
export function confirmIn(row, sentence, does, act, stay = () => row.querySelector("button")?.focus()) {
  const question = questionIn(row, "div", { role: "group", "aria-label": sentence });
  /** @param {string} look @param {string} words @param {() => void} then */
  const answer = (look, words, then) => {
    const onclick = () => {
      question.remove();
      then();
    };
    return make("button", { class: look, onclick }, words);
  };
  const no = answer("button", t("map-card.leave_it"), stay);
  question.append(make("p", sentence), answer("button primary", does, act), no);
  no.focus();
  question.scrollIntoView({ block: "nearest" });
}
