// Button that asks for a second press before it acts.

import { write } from "./element.js";

const ASKS_MS = 6000; // then the button returns to its first label

/**
 * @param {HTMLButtonElement} button of words alone
 * @param {string} question what a second press will do
 * @returns {boolean} true on the second press
 */
export function sure(button, question) {
  const asked = button.dataset["asks"];
  if (asked !== undefined) {
    settle(button, asked);
    return true;
  }
  const words = button.textContent ?? "";
  button.dataset["asks"] = words;
  button.dataset["name"] = button.getAttribute("aria-label") ?? "";
  button.removeAttribute("aria-label");
  write(button, question);
  setTimeout(() => button.dataset["asks"] === words && settle(button, words), ASKS_MS);
  return false;
}

/** @param {HTMLButtonElement} button @param {string} words */
function settle(button, words) {
  write(button, words);
  if (button.dataset["name"]) button.setAttribute("aria-label", button.dataset["name"]);
  delete button.dataset["asks"];
  delete button.dataset["name"];
}
