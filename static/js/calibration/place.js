// Where in the wizards we are, as the address tells it, so that a reload returns to the same place.

/** @typedef {import("./shape.js").Kind} Kind */
/** @typedef {{at: "home"}} Home */
/** @typedef {{at: "new", kind: Kind}} New */
/** @typedef {{at: "capture" | "review", id: string}} Within */
/** @typedef {{at: "microphones"}} Microphones */
/** @typedef {Home | New | Within | Microphones} Place */

/**
 * @param {string} hash of the address, with or without its "#"
 * @returns {Place}
 */
export function placeOf(hash) {
  const told = new URLSearchParams(hash.replace(/^#/, ""));
  if (told.has("microphones")) return { at: "microphones" };
  const fresh = told.get("new");
  if (fresh === "camera" || fresh === "laser") return { at: "new", kind: fresh };
  const id = told.get("s") ?? "";
  if (!/^[\w-]{1,64}$/.test(id)) return { at: "home" };
  return { at: told.has("review") ? "review" : "capture", id };
}

/** @param {Place} place */
export function hashOf(place) {
  if (place.at === "home") return "#";
  if (place.at === "microphones") return "#microphones";
  if (place.at === "new") return `#new=${place.kind}`;
  return place.at === "review" ? `#s=${place.id}&review` : `#s=${place.id}`;
}
