// Button with an icon and a label, both of which can change.

import { icon, make, redraw, write } from "../ui/element.js";

/** @param {string} drawing @param {string} words @param {() => void} [onclick] */
export const action = (drawing, words, onclick) =>
  make("button.button", { "data-does": drawing, onclick }, icon(drawing), make("span", words));

/** @param {HTMLButtonElement} button @param {string} words @param {string} drawing */
export function say(button, words, drawing) {
  write(/** @type {Element} */ (button.lastElementChild), words);
  redraw(/** @type {SVGElement} */ (button.firstElementChild), drawing);
}
