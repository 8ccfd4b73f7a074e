// Compute the arrow and the words that lead the board from its present place to the advised view.

import { t } from "../ui/texts.js";

/** @import { Pixel } from "./types.js" */
/**
 * @typedef {object} Hint
 * @property {Pixel} from middle of the board
 * @property {Pixel} to middle of the wanted view
 * @property {string} words
 * @property {boolean} there near enough
 */

const FAR = 0.07; // of the picture's width
const NEARER = 1.18; // times larger
const SHAPE = 0.05; // of the picture's width that corners are off, on average, after moving and scaling

/**
 * @param {Pixel[]} corners where the board is
 * @param {Pixel[]} wanted where it should be
 * @param {number} width of the picture
 * @returns {Hint | null} null where there is nothing to compare
 */
export function hint(corners, wanted, width) {
  if (!corners.length || corners.length !== wanted.length) return null;
  const [from, to] = [middle(corners), middle(wanted)];
  const scale = spread(wanted, to) / Math.max(spread(corners, from), 1e-9);
  const [across, down] = [to[0] - from[0], to[1] - from[1]];
  /** @type {string[]} */
  const directions = [];
  if (Math.abs(across) > FAR * width) directions.push(across > 0 ? t("board-hint.right") : t("board-hint.left"));
  if (Math.abs(down) > FAR * width) directions.push(down > 0 ? t("board-hint.down") : t("board-hint.up"));
  if (scale > NEARER) directions.push(t("board-hint.closer"));
  else if (scale < 1 / NEARER) directions.push(t("board-hint.farther"));
  if (!directions.length && shapes(corners, wanted, from, to, scale) > SHAPE * width)
    directions.push(t("board-hint.tilt_it_as_drawn"));
  return { from, to, words: directions.join(", "), there: directions.length === 0 };
}

/** @param {Pixel[]} pixels @returns {Pixel} */
function middle(pixels) {
  const sum = pixels.reduce(([u, v], [a, b]) => [u + a, v + b], [0, 0]);
  return [sum[0] / pixels.length, sum[1] / pixels.length];
}

/** @param {Pixel[]} pixels @param {Pixel} about */
function spread(pixels, about) {
  return Math.sqrt(pixels.reduce((sum, [u, v]) => sum + (u - about[0]) ** 2 + (v - about[1]) ** 2, 0) / pixels.length);
}

/**
 * Mean distance of corresponding corners once middle and size agree; the corners may be listed in reverse order.
 * @param {Pixel[]} corners
 * @param {Pixel[]} wanted
 * @param {Pixel} from
 * @param {Pixel} to
 * @param {number} scale
 */
function shapes(corners, wanted, from, to, scale) {
  const placed = corners.map(([u, v]) => [to[0] + (u - from[0]) * scale, to[1] + (v - from[1]) * scale]);
  /** @param {Pixel[]} others */
  const apart = (others) =>
    placed.reduce((sum, [u = 0, v = 0], i) => {
      const [a, b] = others[i] ?? [0, 0];
      return sum + Math.hypot(u - a, v - b);
    }, 0) / placed.length;
  return Math.min(apart(wanted), apart([...wanted].reverse()));
}
