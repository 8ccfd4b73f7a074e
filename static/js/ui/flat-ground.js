// What lies still in the map from above: floor, walls, lines a metre apart. Painted once, shown at every frame.

import { drawPlan, fresh } from "./place-drawing.js";

/** @import { Plan } from "../net/maps-api.js" */
/** @import { Point } from "./floor-view.js" */

const NEAR_M = 0.15; // of a wall: what the laser sees there is the wall
const CELL_M = 0.05;
const MAX_CELLS = 4_000_000;

export class FlatGround {
  #canvas = document.createElement("canvas");
  #painted = "";
  /** @type {Plan | null} */
  #plan = null;
  #number = 0; // of the plan
  /** @type {{columns: number, rows: number, left: number, top: number, near: Uint8ClampedArray} | null} */
  #walls = null;

  /**
   * The canvas of all that lies still, as large as the one it is drawn on.
   * @param {HTMLCanvasElement} canvas
   * @param {import("./floor-view.js").FloorView} view
   * @param {Plan | null} plan
   * @param {boolean} lines a metre apart
   * @param {(name: string) => string} colour
   */
  picture(canvas, view, plan, lines, colour) {
    this.#take(plan);
    const { clientWidth: width, clientHeight: height } = canvas;
    const parts = [width, height, devicePixelRatio, view.scale, view.left, view.top, this.#number, lines];
    const wanted = [...parts, colour("plan-wall")].join(" ");
    if (wanted === this.#painted) return this.#canvas;
    const context = fresh(this.#canvas, { width, height });
    if (!context) return this.#canvas;
    this.#painted = wanted;
    if (plan) drawPlan(context, view, plan, colour);
    if (lines) drawLines(context, view, { width, height }, colour("plan-line"));
    return this.#canvas;
  }

  /** True where a wall of the map is what the laser sees. @param {Point} point [m] */
  explains({ x, y }) {
    if (!this.#walls) return true;
    const { columns, rows, left, top, near } = this.#walls;
    const [column, row] = [Math.floor((x - left) / CELL_M), Math.floor((top - y) / CELL_M)];
    if (column < 0 || row < 0 || column >= columns || row >= rows) return false;
    return (near[4 * (row * columns + column) + 3] ?? 0) > 0;
  }

  /** @param {Plan | null} plan */
  #take(plan) {
    if (plan === this.#plan) return;
    this.#plan = plan;
    this.#number += 1;
    this.#walls = plan ? nearWalls(plan) : null;
  }
}

const CLOSE_LINES_PX = 20;

/** Where a wall is near, cell by cell. @param {Plan} plan */
function nearWalls({ walls, extent }) {
  const [left, top] = [extent.left - 2 * NEAR_M, extent.top + 2 * NEAR_M];
  const columns = Math.ceil((extent.right + 2 * NEAR_M - left) / CELL_M);
  const rows = Math.ceil((top - extent.bottom + 2 * NEAR_M) / CELL_M);
  if (!(columns * rows > 0 && columns * rows < MAX_CELLS)) return null;
  const canvas = new OffscreenCanvas(columns, rows);
  const context = canvas.getContext("2d", { willReadFrequently: true });
  if (!context) return null;
  context.setTransform(1 / CELL_M, 0, 0, -1 / CELL_M, -left / CELL_M, top / CELL_M);
  context.lineWidth = 2 * NEAR_M;
  context.fill(walls, "evenodd");
  context.stroke(walls);
  return { columns, rows, left, top, near: context.getImageData(0, 0, columns, rows).data };
}

/**
 * @param {CanvasRenderingContext2D} context
 * @param {import("./floor-view.js").FloorView} view
 * @param {{width: number, height: number}} size [px]
 * @param {string} colour
 */
function drawLines(context, view, { width, height }, colour) {
  const step = view.scale < 12 ? ([5, 25].find((metres) => metres * view.scale >= CLOSE_LINES_PX) ?? 100) : 1;
  const first = view.floor({ x: 0, y: height });
  const last = view.floor({ x: width, y: 0 });
  context.strokeStyle = colour;
  context.lineWidth = 1;
  context.beginPath();
  for (let x = Math.ceil(first.x / step) * step; x <= last.x; x += step) {
    const at = Math.round(view.drawn({ x, y: 0 }).x) + 0.5;
    context.moveTo(at, 0);
    context.lineTo(at, height);
  }
  for (let y = Math.ceil(first.y / step) * step; y <= last.y; y += step) {
    const at = Math.round(view.drawn({ x: 0, y }).y) + 0.5;
    context.moveTo(0, at);
    context.lineTo(width, at);
  }
  context.stroke();
}
