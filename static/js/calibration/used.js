// The calibrations in use, in words.

import { age, fixed } from "../format.js";

/** @typedef {import("./shape.js").Kind} Kind */

/**
 * @param {Kind} kind
 * @param {Record<string, any>} report
 */
export function inWords(kind, report) {
  const when = typeof report["accepted_s"] === "number" ? `, ${since(report["accepted_s"])}` : "";
  if (kind === "laser") return `In use: ${report["landing_words"] ?? "a calibrated mount"}${when}`;
  const p95 = report["uncertainty"]?.p95_px ?? report["p95_uncertainty_px"];
  const sure = typeof p95 === "number" ? `, 95 % of the picture known to ±${fixed(p95, 2)} px` : "";
  const focal =
    typeof report["fx"] === "number" ? `focal length ${fixed(report["fx"], 1)} px` : "a calibrated camera";
  return `In use: ${focal}${sure}${when}.`;
}

/** @param {number} at Unix time [s] */
export function since(at) {
  const seconds = Date.now() / 1000 - at;
  return seconds < 60
    ? "just now"
    : seconds < 86400
      ? `${age(seconds)} ago`
      : new Date(at * 1000).toLocaleDateString();
}
