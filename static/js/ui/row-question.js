// A question in a row of a list, which asks one at a time.
// Button that asks for a second press before it acts.

import { make, write } from "./element.js";
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

const ASKS_MS = 6000; // then the button returns to its first label

/** @param {HTMLButtonElement} button of words, or of a drawing and words */
const wordsOf = (button) => button.querySelector("span") ?? button;

/**
 * @param {HTMLButtonElement} button of words, or of a drawing and words
 * @param {string} question what a second press will do
 * @returns {boolean} true on the second press
 */
export function sure(button, question) {
  const asked = button.dataset["asks"];
  if (asked !== undefined) {
    settle(button, asked);
    return true;
  }
  const words = wordsOf(button).textContent ?? "";
  button.dataset["asks"] = words;
  button.dataset["name"] = button.getAttribute("aria-label") ?? "";
  button.removeAttribute("aria-label");
  write(wordsOf(button), question);
  setTimeout(() => button.dataset["asks"] === words && settle(button, words), ASKS_MS);
  return false;
}

/** @param {HTMLButtonElement} button @param {string} words */
function settle(button, words) {
  write(wordsOf(button), words);
  if (button.dataset["name"]) button.setAttribute("aria-label", button.dataset["name"]);
  delete button.dataset["asks"];
  delete button.dataset["name"];
}
