// Theme of the page: auto, dark or light; the choice is stored.

import { remember, remembered } from "./local-storage.js";

/** @typedef {"auto" | "dark" | "light"} Theme */

const ORDER = /** @type {const} */ (["auto", "dark", "light"]);
const darkRoom = matchMedia("(prefers-color-scheme: dark)");
/** @type {Set<() => void>} */
const listeners = new Set();

/** @returns {Theme} */
export function theme() {
  const chosen = document.documentElement.dataset["theme"];
  return chosen === "dark" || chosen === "light" ? chosen : "auto";
}

export const isDark = () => (theme() === "auto" ? darkRoom.matches : theme() === "dark");

function tell() {
  document.documentElement.toggleAttribute("data-dark", isDark()); // for pictures that are drawn for white paper
  for (const listener of listeners) listener();
}

/** @param {string} choice */
export function choose(choice) {
  if (choice === "dark" || choice === "light") document.documentElement.dataset["theme"] = choice;
  else delete document.documentElement.dataset["theme"];
  remember("theme", theme());
  tell();
}

/** @returns {Theme} what follows the present one when the button is pressed */
export const next = () => ORDER[(ORDER.indexOf(theme()) + 1) % ORDER.length] ?? "auto";

/** @param {() => void} listener called when light turns dark or dark light */
export function onTheme(listener) {
  listeners.add(listener);
}

darkRoom.addEventListener("change", tell);
choose(remembered("theme", "auto"));
