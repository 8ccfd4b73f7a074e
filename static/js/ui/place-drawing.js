// Drawing of the map from above with a proposed robot pose and the laser scan seen from there.

import { seenFrom } from "./floor-view.js";
import { onTheme } from "./theme.js";

/** @import { Point } from "./floor-view.js" */

export const NOSE = 1.8; // how far the robot's nose is from its middle, in radii
const WALL_EDGE_PX = 1.5; // so that a wall is seen from far away

/** @typedef {{x: number, y: number, heading: number | null}} Placed heading null: unknown */
/**
 * @typedef {object} Place
 * @property {import("../net/maps-api.js").Plan} plan
 * @property {Array<[number, number]>} scan what the laser meets now, in the robot's frame [m]
 * @property {Placed | null} placed
 * @property {readonly {x_m: number, y_m: number, heading_rad: number}[]} candidates where it may be, likeliest first
 * @property {number} radius [m] of the robot
 */

/**
 * @param {HTMLCanvasElement} canvas its CSS custom properties define the colours
 * @param {import("./floor-view.js").FloorView} view
 * @param {Place} place
 */
export function drawPlace(canvas, view, { plan, scan, placed, candidates, radius: metres }) {
  const context = fresh(canvas);
  if (!context) return;
  /** @param {string} name */
  const colour = (name) => colourOf(canvas, name);
  drawPlan(context, view, plan, colour);
  const radius = Math.max(7, view.scale * metres);
  for (const [index, { x_m: x, y_m: y, heading_rad: heading }] of candidates.entries()) {
    const strength = index === 0 ? 0.75 : 0.45;
    drawRobot(context, view.drawn({ x, y }), heading, {
      radius: 0.8 * radius,
      colour: colour("scene-ghost"),
      strength,
    });
  }
  if (!placed) return;
  const { heading } = placed;
  if (heading !== null) {
    context.fillStyle = colour("scene-scan");
    const dot = Math.min(3, Math.max(1.6, 0.05 * view.scale));
    for (const point of seenFrom(scan, { ...placed, heading })) {
      const { x, y } = view.drawn(point);
      context.fillRect(x - dot / 2, y - dot / 2, dot, dot);
    }
  }
  drawRobot(context, view.drawn(placed), heading, {
    radius,
    colour: colour("scene-pose"),
    strength: 1,
    edge: colour("surface"),
  });
}

/**
 * The floor in one even tint and the walls on it, as sharp at every scale.
 * @param {CanvasRenderingContext2D} context
 * @param {import("./floor-view.js").FloorView} view
 * @param {import("../net/maps-api.js").Plan} plan
 * @param {(name: string) => string} colour
 */
export function drawPlan(context, { scale, left, top }, { walls, floor }, colour) {
  context.save();
  context.transform(scale, 0, 0, -scale, left, top);
  context.fillStyle = colour("plan-floor");
  context.fill(floor, "evenodd");
  context.fillStyle = context.strokeStyle = colour("plan-wall");
  context.lineWidth = WALL_EDGE_PX / scale;
  context.lineJoin = "round";
  context.fill(walls, "evenodd");
  context.stroke(walls);
  context.restore();
}

/** @type {Map<string, string>} */
const colours = new Map();
onTheme(() => colours.clear());

/**
 * Colour of a token, as the theme has it now: a brush does not know `light-dark()`.
 * @param {HTMLElement} element that has no colour of its own
 * @param {string} name
 */
export function colourOf(element, name) {
  const known = colours.get(name);
  if (known) return known;
  element.style.color = `var(--${name})`;
  const { color } = getComputedStyle(element);
  element.style.color = "";
  colours.set(name, color);
  return color;
}

let face = "";

/** Font of words in a drawing: the page's own. @param {number} size [px] */
export function fontOf(size) {
  face ||= getComputedStyle(document.body).fontFamily;
  return `600 ${size}px ${face}`;
}

/**
 * The canvas's brush, after its size was fitted and everything wiped.
 * @param {HTMLCanvasElement} canvas
 * @param {{width: number, height: number}} [size] [px] of one that is not in the page
 */
export function fresh(canvas, size = { width: canvas.clientWidth, height: canvas.clientHeight }) {
  const context = canvas.getContext("2d");
  const { width, height } = size;
  const fine = devicePixelRatio || 1;
  if (canvas.width !== Math.round(width * fine)) canvas.width = Math.round(width * fine);
  if (canvas.height !== Math.round(height * fine)) canvas.height = Math.round(height * fine);
  context?.setTransform(fine, 0, 0, fine, 0, 0);
  context?.clearRect(0, 0, width, height);
  return context;
}

/** A line through points. @param {CanvasPath} path @param {readonly Point[]} points [px] @param {boolean} [closed] */
export function trace(path, points, closed = false) {
  for (const [index, { x, y }] of points.entries()) {
    if (index) path.lineTo(x, y);
    else path.moveTo(x, y);
  }
  if (closed) path.closePath();
}

/** @param {CanvasRenderingContext2D} context @param {Point} at its middle [px] @param {number} reach of its arms [px] */
export function drawCross(context, { x, y }, reach) {
  context.beginPath();
  context.moveTo(x - reach, y);
  context.lineTo(x + reach, y);
  context.moveTo(x, y - reach);
  context.lineTo(x, y + reach);
  context.stroke();
}

/**
 * The robot from above: round, with a nose where it looks.
 * @param {CanvasRenderingContext2D} context
 * @param {Point} at [px]
 * @param {number | null} heading
 * @param {{radius: number, colour: string, strength: number, edge?: string}} look radius [px], strength 0..1,
 *   edge: colour around the robot itself, which is solid; others are seen through
 */
export function drawRobot(context, { x, y }, heading, { radius, colour, strength, edge }) {
  context.save();
  context.fillStyle = colour;
  context.strokeStyle = edge ?? colour;
  context.lineWidth = 2.5;
  context.lineJoin = "round";
  context.beginPath();
  if (heading === null) {
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.setLineDash([4, 5]);
  } else {
    const side = Math.acos(1 / NOSE);
    context.arc(x, y, radius, side - heading, 2 * Math.PI - side - heading);
    context.lineTo(x + NOSE * radius * Math.cos(heading), y - NOSE * radius * Math.sin(heading));
    context.closePath();
  }
  context.globalAlpha = edge ? strength : 0.25 * strength;
  context.fill();
  context.globalAlpha = strength;
  context.stroke();
  if (edge) {
    context.fillStyle = edge;
    context.beginPath();
    context.arc(x, y, 0.3 * radius, 0, 2 * Math.PI);
    context.fill();
  }
  context.restore();
}
