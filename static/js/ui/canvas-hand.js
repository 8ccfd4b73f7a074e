// Fingers, mouse and wheel on a canvas: pressed, drawn, dragged, pinched.

import { apart } from "./flat-drawing.js";

/** @import { Point } from "./floor-view.js" */
/**
 * @typedef {object} Acts what the canvas does, at places in pixels
 * @property {(about: Point, times: number, shift: Point) => void} move the drawing, larger by `times` about a point
 * @property {(at: Point, event: PointerEvent) => void} [press] which was no drag
 * @property {(at: Point) => boolean} [draw] a finger goes down; true: it draws, and moves nothing
 * @property {(at: Point, from: Point) => void} [drawn] it went on, from where it drew last
 * @property {() => void} [ended] it was lifted
 * @property {boolean} [scrolls] true: a wheel scrolls the page
 * @property {() => void} [left] a second finger came: nothing is drawn any more
 */

const LINE = 40; // [px] that a wheel scrolls by one line
const DRAG = 7; // [px] from which a press is a drag

/** @type {Readonly<Record<string, readonly [number, number]>>} */
const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

/**
 * Where an arrow key takes a cursor; null for another key.
 * @param {KeyboardEvent} event
 * @param {Point} from [m]
 * @param {readonly [number, number]} steps [m] without and with Shift
 */
export function stepped({ key, shiftKey }, { x, y }, steps) {
  const arrow = ARROWS[key];
  const step = steps[shiftKey ? 1 : 0];
  return arrow ? { x: x + step * arrow[0], y: y + step * arrow[1] } : null;
}

export class CanvasHand {
  /** @type {Map<number, Point>} */
  #fingers = new Map();
  /** @type {Point | null} */
  #pressed = null; // [px], while it may still be a press
  #draws = false;
  #canvas;
  #acts;

  /** @param {HTMLCanvasElement} canvas @param {Acts} acts */
  constructor(canvas, acts) {
    this.#canvas = canvas;
    this.#acts = acts;
    canvas.addEventListener("mousedown", (event) => event.preventDefault()); // the arrow keys stay the robot's
    canvas.addEventListener("pointerdown", (event) => this.#down(event));
    canvas.addEventListener("pointermove", (event) => this.#drag(event));
    canvas.addEventListener("pointerup", (event) => this.#up(event));
    canvas.addEventListener("pointercancel", (event) => this.#cancel(event));
    // else the click that follows a tap presses what the tap has just opened there
    canvas.addEventListener("touchend", (event) => event.cancelable && event.preventDefault(), { passive: false });
    if (!acts.scrolls) canvas.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
  }

  /** @param {PointerEvent} event */
  #down(event) {
    if (event.button !== 0) return;
    const at = pointOf(event);
    this.#canvas.setPointerCapture(event.pointerId);
    this.#fingers.set(event.pointerId, at);
    const alone = this.#fingers.size === 1;
    if (this.#draws && !alone) this.#acts.left?.();
    this.#draws = alone && this.#acts.draw?.(at) === true;
    this.#pressed = alone && !this.#draws ? at : null;
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
      this.#acts.move(middle, times, { x: (now.x - before.x) / 2, y: (now.y - before.y) / 2 });
    } else if (this.#draws) this.#acts.drawn?.(now, before);
    else this.#acts.move(now, 1, { x: now.x - before.x, y: now.y - before.y });
  }

  /** @param {PointerEvent} event */
  #up(event) {
    const [at, drew] = [this.#pressed, this.#draws];
    this.#fingers.delete(event.pointerId);
    [this.#pressed, this.#draws] = [null, false];
    if (at) this.#acts.press?.(at, event);
    if (drew) this.#acts.ended?.();
  }

  /** @param {PointerEvent} event the browser took it, as to scroll */
  #cancel(event) {
    this.#fingers.delete(event.pointerId);
    if (this.#draws) this.#acts.left?.();
    [this.#pressed, this.#draws] = [null, false];
  }

  /** @param {WheelEvent} event */
  #wheel(event) {
    event.preventDefault();
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? event.deltaY / LINE : event.deltaY;
    this.#acts.move(pointOf(event), 1.12 ** -lines, { x: 0, y: 0 });
  }
}

/** @param {MouseEvent} event */
const pointOf = ({ offsetX: x, offsetY: y }) => ({ x, y });
