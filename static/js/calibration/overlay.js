// Drawing functions over a picture: found corners, advised view, arrow, laser points.

import { rangeColour } from "../ui/colormap.js";
import { fontOf, trace } from "../ui/place-drawing.js";

/** @import { Hint } from "./board-hint.js" */
/** @import { Advice, Pixel } from "./types.js" */
/**
 * @typedef {object} Sheet a canvas over a picture
 * @property {CanvasRenderingContext2D} brush
 * @property {(pixel: Pixel) => Pixel} place picture pixel → canvas
 * @property {number} unit canvas pixels per CSS pixel
 */

const FOUND = "#43d1e8";
const COUNTED = "#63d69a";
const REFUSED = "#f3b453";
const WANTED = "#f08ae8";
const UNDER = "rgb(0 0 0 / 0.6)";

/** @type {Readonly<Record<string, string>>} */
const COLOURS = { counted: COUNTED, refused: REFUSED, same: REFUSED, trouble: REFUSED };

/**
 * The rows of corners as strings of beads.
 * @param {Sheet} sheet
 * @param {Pixel[]} corners
 * @param {number} columns
 * @param {string} kind of the verdict
 */
export function drawCorners({ brush, place, unit }, corners, columns, kind) {
  const path = new Path2D();
  const beads = new Path2D();
  const radius = 3 * unit;
  corners.forEach((corner, index) => {
    const [x, y] = place(corner);
    if (index % columns === 0) path.moveTo(x, y);
    else path.lineTo(x, y);
    beads.moveTo(x + radius, y);
    beads.arc(x, y, radius, 0, 2 * Math.PI);
  });
  stroke(brush, path, COLOURS[kind] ?? FOUND, 1.25 * unit);
  brush.fillStyle = COLOURS[kind] ?? FOUND;
  brush.strokeStyle = UNDER;
  brush.lineWidth = unit;
  brush.fill(beads);
  brush.stroke(beads);
  const first = corners[0];
  if (!first || corners.length < columns) return;
  const ring = new Path2D();
  const [x, y] = place(first);
  ring.arc(x, y, 2.4 * radius, 0, 2 * Math.PI);
  stroke(brush, ring, COLOURS[kind] ?? FOUND, 1.5 * unit);
}

/**
 * The ghost of the next view: the panel's rim and the rim of its corners.
 * @param {Sheet} sheet
 * @param {Advice} advice
 * @param {number} columns
 */
export function drawGhost({ brush, place, unit }, { outline, corners }, columns) {
  brush.save();
  const rim = ring(outline, place);
  brush.fillStyle = "rgb(240 138 232 / 0.16)";
  brush.fill(rim);
  brush.setLineDash([9 * unit, 6 * unit]);
  stroke(brush, rim, WANTED, 2.25 * unit);
  brush.setLineDash([]);
  const count = corners.length;
  const ends = [0, columns - 1, count - 1, count - columns].map((index) => corners[index]);
  const inner = ends.filter((corner) => corner !== undefined);
  stroke(brush, ring(inner, place), "rgb(240 138 232 / 0.75)", 1.25 * unit);
  brush.restore();
}

/** @param {Sheet} sheet @param {Hint} way @param {(words: string) => string} spoken as the person sees it */
export function drawWay({ brush, place, unit }, way, spoken) {
  const [from, to] = [place(way.from), place(way.to)];
  const length = Math.hypot(to[0] - from[0], to[1] - from[1]);
  if (length > 26 * unit) {
    const [x, y] = [(to[0] - from[0]) / length, (to[1] - from[1]) / length];
    const head = 13 * unit;
    const arrow = new Path2D();
    arrow.moveTo(from[0], from[1]);
    arrow.lineTo(to[0], to[1]);
    arrow.moveTo(to[0] - head * (x + 0.6 * y), to[1] - head * (y - 0.6 * x));
    arrow.lineTo(to[0], to[1]);
    arrow.lineTo(to[0] - head * (x - 0.6 * y), to[1] - head * (y + 0.6 * x));
    stroke(brush, arrow, WANTED, 4 * unit);
  }
  if (way.words) label({ brush, place, unit }, spoken(way.words), to[0], to[1] + 26 * unit);
}

/**
 * The laser's points: on the board bright, elsewhere by distance.
 * @param {Sheet} sheet
 * @param {Array<[number, number, number, boolean]>} points u, v, range [m], on the board
 */
export function drawLaser({ brush, place, unit }, points) {
  for (const [u, v, range, onBoard] of points) {
    const [x, y] = place([u, v]);
    const size = (onBoard ? 5 : 3) * unit;
    brush.fillStyle = UNDER;
    brush.fillRect(x - size / 2 - unit, y - size / 2 - unit, size + 2 * unit, size + 2 * unit);
    brush.fillStyle = onBoard ? WANTED : rangeColour(range);
    brush.fillRect(x - size / 2, y - size / 2, size, size);
  }
}

/**
 * @param {Sheet} sheet
 * @param {string} words
 * @param {number} x
 * @param {number} y
 */
function label({ brush, unit }, words, x, y) {
  brush.font = fontOf(13 * unit);
  const half = brush.measureText(words).width / 2 + 9 * unit;
  const left = Math.min(Math.max(x, half + 4 * unit), brush.canvas.width - half - 4 * unit);
  const top = Math.min(Math.max(y, 16 * unit), brush.canvas.height - 16 * unit);
  brush.fillStyle = "rgb(24 6 28 / 0.82)";
  brush.beginPath();
  brush.roundRect(left - half, top - 13 * unit, 2 * half, 26 * unit, 13 * unit);
  brush.fill();
  brush.fillStyle = "#ffd9fb";
  brush.textAlign = "center";
  brush.textBaseline = "middle";
  brush.fillText(words, left, top + unit);
}

/** @param {Pixel[]} pixels @param {(pixel: Pixel) => Pixel} place */
function ring(pixels, place) {
  const path = new Path2D();
  const points = pixels.map(place).map(([x, y]) => ({ x, y }));
  trace(path, points, true);
  return path;
}

/**
 * A line that shows on light and on dark.
 * @param {CanvasRenderingContext2D} brush
 * @param {Path2D} path
 * @param {string} colour
 * @param {number} width
 */
function stroke(brush, path, colour, width) {
  brush.lineCap = "round";
  brush.lineJoin = "round";
  brush.strokeStyle = UNDER;
  brush.lineWidth = width * 1.9;
  brush.stroke(path);
  brush.strokeStyle = colour;
  brush.lineWidth = width;
  brush.stroke(path);
}
