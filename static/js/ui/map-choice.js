// Which of the two maps is shown, flat or 3-D: what was chosen, else what suits this browser.

import { remember, remembered } from "./local-storage.js";
import { t } from "./texts.js";

/** @typedef {"flat" | "3-D"} MapKind */

const SMALL = "(max-width: 600px), (max-height: 450px)"; // phones
export const MAP_DRAWN = canDraw();
export const NO_WEBGL = t("map-choice.this_browser_has_no_webgl_2");

/** @type {Set<() => void>} */
const listeners = new Set();
let why = MAP_DRAWN || matchMedia(SMALL).matches ? "" : t("map-choice.no_webgl_2_flat_map"); // a phone has it flat anyway
/** @type {MapKind} */
let kind = suitable(MAP_DRAWN, remembered("map", ""), matchMedia(SMALL).matches || remembered("map-slow", "") !== "");

/**
 * @param {boolean} drawable whether this browser can draw the 3-D map
 * @param {string} chosen what was chosen before, "" for nothing
 * @param {boolean} better whether the flat one suits this screen or this computer better
 * @returns {MapKind}
 */
export function suitable(drawable, chosen, better) {
  if (!drawable) return "flat";
  if (chosen === "flat" || chosen === "3-D") return chosen;
  return better ? "flat" : "3-D";
}

let proven = false; // the 3-D map draws

/** @returns {MapKind} */
export const mapKind = () => kind;

/** @returns {MapKind} what is drawn now: the flat map, too, until the 3-D one has shown that it draws */
export const mapShown = () => (kind === "3-D" && (proven || isChosen()) ? "3-D" : "flat");

/** The 3-D map draws, and takes the flat one's place. */
export function prove() {
  if (proven) return;
  proven = true;
  for (const listener of listeners) listener();
}

/** @returns {string} a sentence: why the map is flat though nobody chose it; "" for none */
export const whyFlat = () => why;

/** @returns {boolean} whether someone chose, who is not overruled */
export const isChosen = () => remembered("map", "") !== "";

/** @param {MapKind} chosen by the person at the screen */
export function chooseMap(chosen) {
  remember("map", chosen);
  change(chosen, "");
}

/** @param {string} because a sentence: why the 3-D map does not serve, now and when the page is loaded again */
export function fallBack(because) {
  remember("map-slow", "yes");
  change("flat", because);
}

/** @param {() => void} listener called when the other map is to be shown */
export function onMapKind(listener) {
  listeners.add(listener);
}

/** @param {MapKind} to @param {string} because */
function change(to, because) {
  if (!MAP_DRAWN) return;
  [kind, why] = [to, because];
  for (const listener of listeners) listener();
}

/** Whether this browser can draw the 3-D map. */
function canDraw() {
  try {
    const context = document.createElement("canvas").getContext("webgl2");
    context?.getExtension("WEBGL_lose_context")?.loseContext(); // browsers keep few of them
    return context !== null;
  } catch {
    return false;
  }
}
