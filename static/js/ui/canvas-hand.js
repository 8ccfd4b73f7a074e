// Fingers, mouse and wheel on a canvas: dragged, pinched, pressed.

import { apart } from "./flat-drawing.js";

/** @import { Point } from "./floor-view.js" */

const LINE = 40; // [px] that a wheel scrolls by one line
const DRAG = 7; // [px] from which a press is a drag

export class CanvasHand {
  /** @type {Map<number, Point>} */
  #fingers = new Map();
  /** @type {Point | null} */
  #pressed = null; // [px], while it may still be a press
  #canvas;
  #move;
  #press;

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {(about: Point, times: number, shift: Point) => void} move the drawing, larger by `times` about a point
   * @param {(at: Point, event: PointerEvent) => void} press
   */
  constructor(canvas, move, press) {
    this.#canvas = canvas;
    this.#move = move;
    this.#press = press;
    canvas.addEventListener("mousedown", (event) => event.preventDefault()); // the arrow keys stay the robot's
    canvas.addEventListener("pointerdown", (event) => this.#down(event));
    canvas.addEventListener("pointermove", (event) => this.#drag(event));
    canvas.addEventListener("pointerup", (event) => this.#up(event));
    canvas.addEventListener("pointercancel", (event) => this.#fingers.delete(event.pointerId));
    canvas.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
  }

  /** @param {PointerEvent} event */
  #down(event) {
    if (event.button !== 0) return;
    this.#canvas.setPointerCapture(event.pointerId);
    this.#fingers.set(event.pointerId, pointOf(event));
    this.#pressed = this.#fingers.size === 1 ? pointOf(event) : null;
  }

  /** @param {PointerEvent} event */
  #drag(event) {
    const before = this.#fingers.get(event.pointerId);
    if (!before) return;
    const now = pointOf(event);
    const other = [...this.#fingers].find(([id]) => id !== event.pointerId)?.[1];
    if (this.#pressed && apart(this.#pressed, now) < DRAG) return;
    this.#pressed = null;
    this.#fingers.set(event.pointerId, now);
    if (other) {
      const middle = { x: (before.x + other.x) / 2, y: (before.y + other.y) / 2 };
      const times = apart(now, other) / Math.max(1, apart(before, other));
      this.#move(middle, times, { x: (now.x - before.x) / 2, y: (now.y - before.y) / 2 });
    } else this.#move(now, 1, { x: now.x - before.x, y: now.y - before.y });
  }

  /** @param {PointerEvent} event */
  #up(event) {
    const at = this.#pressed;
    this.#fingers.delete(event.pointerId);
    this.#pressed = null;
    if (at) this.#press(at, event);
  }

  /** @param {WheelEvent} event */
  #wheel(event) {
    event.preventDefault();
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? event.deltaY / LINE : event.deltaY;
    this.#move(pointOf(event), 1.12 ** -lines, { x: 0, y: 0 });
  }
}

/** @param {MouseEvent} event */
const pointOf = ({ offsetX: x, offsetY: y }) => ({ x, y });
