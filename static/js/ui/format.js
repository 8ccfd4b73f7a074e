// Format numbers for the operator. Degrees and centimetres exist only here.

import { t } from "./texts.js";

const MINUS = "−";
const AHEAD = 0.15; // [rad] to either side of straight ahead, or behind, that counts as that in words

/**
 * A number with a fixed count of decimals and a true minus sign; never "−0.00".
 * @param {number | null} value
 * @param {number} decimals
 */
export function fixed(value, decimals) {
  if (value === null || !Number.isFinite(value)) return "–";
  const text = Math.abs(value).toFixed(decimals);
  return value < 0 && Number(text) !== 0 ? MINUS + text : text;
}

/** @param {number} value [m] @param {number} [decimals] */
export function metres(value, decimals = 2) {
  return `${fixed(value, decimals)} m`;
}

/** @param {number} angle [rad] @param {number} [decimals] */
export function degrees(angle, decimals = 0) {
  return Number.isFinite(angle) ? `${fixed((angle * 180) / Math.PI, decimals)}°` : "–";
}

/** A turn in words: left is positive, as everywhere. @param {number} angle [rad] */
export function turn(angle) {
  const text = degrees(Number.isFinite(angle) ? Math.abs(angle) : NaN);
  if (text === "0°" || text === "–") return text;
  return `${text} ${angle > 0 ? t("format.left") : t("format.right")}`;
}

/** @param {number} value [m/s] */
export function speed(value) {
  return `${fixed(value, 2)} m/s`;
}

/** @param {number} value [rad/s] */
export function turnRate(value) {
  return `${degrees(value)}/s`;
}

/** A share in per cent: 0.73 → "73 %"; below one per cent with a decimal. @param {number} part 0..1 */
export function share(part) {
  return `${fixed(100 * part, part > 0 && part < 0.01 ? 1 : 0)} %`;
}

/** How old something is. @param {number} seconds */
export function age(seconds) {
  if (!Number.isFinite(seconds)) return "–";
  if (seconds < 10) return `${fixed(Math.max(seconds, 0), 1)} s`;
  if (seconds < 100) return `${Math.round(seconds)} s`;
  if (seconds < 6000) return `${Math.round(seconds / 60)} min`;
  return `${Math.round(seconds / 3600)} h`;
}

/** A place on a recording's time line: "1:05", "1:02:03". @param {number} seconds */
export function duration(seconds) {
  if (!Number.isFinite(seconds)) return "–";
  const whole = Math.max(0, Math.floor(seconds));
  const [h, m, s] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, whole % 60];
  const tail = `${h && m < 10 ? "0" : ""}${m}:${s < 10 ? "0" : ""}${s}`;
  return h ? `${h}:${tail}` : tail;
}

/** The size of a file: "340 kB", "1.2 MB", "3.4 GB". @param {number} bytes */
export function size(bytes) {
  const [unit = "", one = 1] = bytes < 1e6 ? ["kB", 1e3] : bytes < 1e9 ? ["MB", 1e6] : ["GB", 1e9];
  return `${fixed(bytes / one, bytes < 1e6 || bytes / one >= 100 ? 0 : 1)} ${unit}`;
}

/** The day and the minute of a Unix time: "today, 8:05". @param {number} seconds */
export function day(seconds) {
  const at = new Date(seconds * 1000);
  const clock = timeOfDay(seconds).slice(0, 5);
  if (at.toDateString() === new Date().toDateString()) return t("format.today_clock", { clock });
  return `${date(seconds)} ${clock}`;
}

/** The day of a Unix time as every country reads it: "2026-11-29". @param {number} seconds */
export function date(seconds) {
  return new Date(seconds * 1000).toLocaleDateString("sv");
}

/** Time of day of a Unix time. @param {number} seconds */
export function timeOfDay(seconds) {
  if (!Number.isFinite(seconds)) return "–";
  const at = new Date(seconds * 1000);
  return [at.getHours(), at.getMinutes(), at.getSeconds()].map((part) => String(part).padStart(2, "0")).join(":");
}

/** A number whose key carries its unit: ("distance_m", 1.5) → "1.50 m". @param {string} key @param {number} value */
export function quantity(key, value) {
  if (key.endsWith("_rad_s")) return turnRate(value);
  if (key.endsWith("_m_s")) return speed(value);
  if (key.endsWith("_rad")) return degrees(value);
  if (key.endsWith("_m")) return metres(value);
  if (key.endsWith("_s")) return age(value);
  return fixed(value, 2);
}

/**
 * The numbers of a command, short: {x_m: 2, y_m: 1} → "x 2.00 m, y 1.00 m"; a single one goes without its name.
 * @param {Readonly<Record<string, number>>} numbers
 */
export function quantities(numbers) {
  const entries = Object.entries(numbers);
  if (entries.length === 1) return entries.map(([key, value]) => quantity(key, value)).join("");
  return entries.map(([key, value]) => `${key.replace(/_.*$/, "")} ${quantity(key, value)}`).join(", ");
}

/** Keys of the words for every eighth of the circle, on the left and on the right. @type {ReadonlyArray<[string, string]>} */
const WHERE = [
  ["format.ahead", "format.ahead"],
  ["format.ahead_on_the_left", "format.ahead_on_the_right"],
  ["format.on_the_left", "format.on_the_right"],
  ["format.behind_on_the_left", "format.behind_on_the_right"],
  ["format.behind", "format.behind"],
];

/** Where a point of the robot frame lies, in words. @param {number} x forward [m] @param {number} y left [m] */
export function whereabouts(x, y) {
  const eighth = Math.round(Math.atan2(y, x) / (Math.PI / 4));
  const [left, right] = [WHERE.map(([one]) => one), WHERE.map(([, other]) => other)];
  return t((eighth < 0 ? right : left)[Math.abs(eighth)] ?? "format.near");
}

/** A bearing as people say it: "31° to the right". @param {number} bearing [rad] left positive */
export function inWords(bearing) {
  if (Math.abs(bearing) < AHEAD) return t("format.straight_ahead");
  if (Math.abs(bearing) > Math.PI - AHEAD) return t("format.behind");
  return t("format.degrees_to_the_value", {
    degrees: degrees(Math.abs(bearing)),
    value: bearing > 0 ? t("format.left") : t("format.right"),
  });
}

/**
 * One standard deviation along x, y and the heading from a 3x3 covariance.
 * @param {ReadonlyArray<ReadonlyArray<number>>} covariance [m², rad²]
 */
export function sigmas(covariance) {
  /** @param {number} i */
  const at = (i) => Math.sqrt(Math.max(covariance[i]?.[i] ?? NaN, 0));
  return { x: at(0), y: at(1), heading: at(2) };
}

/** Uncertainty in the unit a person can picture: "± 3 mm", "± 1.2 cm", "± 0.35 m". @param {number} sigma [m] */
export function spread(sigma) {
  if (!Number.isFinite(sigma)) return "± –";
  if (sigma > 0 && sigma < 0.0005) return "± < 1 mm"; // none is only what is defined so
  if (sigma < 0.01) return `± ${fixed(sigma * 1000, 0)} mm`;
  if (sigma < 0.1) return `± ${fixed(sigma * 100, 1)} cm`;
  return `± ${fixed(sigma, 2)} m`;
}

/** The same of a heading: "± 0.3°". @param {number} sigma [rad] */
export function turnSpread(sigma) {
  const text = degrees(sigma, 1);
  return sigma > 0 && text === degrees(0, 1) ? `± < ${degrees(Math.PI / 1800, 1)}` : `± ${text}`;
}

/** The difference of two headings, −π < d ≤ π. @param {number} a [rad] @param {number} b [rad] */
export function headingBetween(a, b) {
  const turns = (a - b) / (2 * Math.PI);
  const left = (turns - Math.round(turns)) * 2 * Math.PI;
  return left <= -Math.PI ? left + 2 * Math.PI : left;
}

/**
 * The longer half axis of a one-sigma ellipse, from a 2x2 covariance.
 * @param {ReadonlyArray<ReadonlyArray<number>>} covariance [m²]
 */
export function largestSigma(covariance) {
  const [a = NaN, b = NaN] = covariance[0] ?? [];
  const d = covariance[1]?.[1] ?? NaN;
  return Math.sqrt(Math.max((a + d) / 2 + Math.hypot((a - d) / 2, b), 0));
}
