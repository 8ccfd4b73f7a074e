// Map the hash of the address to a step of the wizards and back, so that a reload keeps the step.

/** @import { Kind } from "./types.js" */
/** @typedef {{at: "home"}} Home */
/** @typedef {{at: "new", kind: Kind}} New */
/** @typedef {{at: "capture" | "review", id: string}} Within */
/** @typedef {{at: "microphones"}} Microphones */
/** @typedef {Home | New | Within | Microphones} Place */

/** @param {string} hash of the address, with or without its "#" @returns {Place} */
export function placeOf(hash) {
  const query = new URLSearchParams(hash.replace(/^#/, ""));
  if (query.has("microphones")) return { at: "microphones" };
  const fresh = query.get("new");
  if (fresh === "camera" || fresh === "laser") return { at: "new", kind: fresh };
  const id = query.get("s") ?? "";
  if (!/^[\w-]{1,64}$/.test(id)) return { at: "home" };
  return { at: query.has("review") ? "review" : "capture", id };
}

/** @param {Place} place */
export function hashOf(place) {
  if (place.at === "home") return "#";
  if (place.at === "microphones") return "#microphones";
  if (place.at === "new") return `#new=${place.kind}`;
  return place.at === "review" ? `#s=${place.id}&review` : `#s=${place.id}`;
}
