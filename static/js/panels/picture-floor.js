// The floor in the camera's picture: the planned way on it, and the point of it below pointer, finger or cursor.

import { pressedFloor } from "../net/api.js";
import { stepped } from "../ui/canvas-hand.js";
import { fixed, metres } from "../ui/format.js";
import { goTo } from "../ui/go-to.js";
import { colourOf, drawCross, fontOf, trace } from "../ui/place-drawing.js";
import { t } from "../ui/texts.js";

/** @import { CameraOverlay } from "../net/messages.js" */
/** @import { PressedFloor } from "../net/rest.js" */
/** @import { Session } from "../net/session.js" */
/** @import { Point } from "../ui/floor-view.js" */

const ASK_MS = 120; // between two questions while the pointer moves
const STEPS_PX = /** @type {const} */ ([6, 24]); // of the keyboard's cursor, and with Shift
const BEGIN = { x: 0.5, y: 0.68 }; // of the cursor, in sides of the picture
const LABEL_PX = 15;
const [NEAR_PX, LEAST_PX] = [5, 1.5]; // half the width of the way at a metre, and far away
const [FADES_M, FAINTEST] = [8, 0.45]; // distance over which the way fades, and what stays of it
const DARK = "rgb(0 0 0 / 0.55)";

/** Where the pointer is on the floor of a picture; a press sends the robot there. */
export class PictureFloor {
  /** @type {HTMLCanvasElement} */
  #canvas;
  #panel;
  #picture;
  #changed;
  #on = false;
  /** @type {Point | null} [pixel] of the keyboard */
  #cursor = null;
  #hovers = false;
  /** @type {Point | null} [pixel] that is asked for next */
  #wanted = null;
  #asks = false;
  /** @type {PressedFloor | null} */
  #found = null;

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {{session: Session}} panel that it is in
   * @param {() => {width: number, height: number, stamp: number}} picture that is shown [pixel], [s]
   * @param {() => void} changed it is to be drawn again
   */
  constructor(canvas, panel, picture, changed) {
    this.#canvas = canvas;
    this.#panel = panel;
    this.#picture = picture;
    this.#changed = changed;
    canvas.addEventListener("mousedown", (event) => event.preventDefault()); // the arrow keys stay the robot's
    canvas.addEventListener("pointermove", (event) => event.pointerType === "mouse" && this.#hover(event));
    canvas.addEventListener("pointerleave", () => this.#leave());
    canvas.addEventListener("focus", () => canvas.matches(":focus-visible") && this.#move(this.#begin));
    canvas.addEventListener("blur", () => this.#leave());
    canvas.addEventListener("click", (event) => void this.#press(this.#pixel(event)));
    canvas.addEventListener("keydown", (event) => this.#key(event));
  }

  /** Whether a press sends the robot. @param {boolean} on @param {string} shows what the picture shows, in words */
  allow(on, shows) {
    const canvas = this.#canvas;
    const says = on ? `${shows}. ${t("camera-view.arrows_move_a_point")}` : shows;
    if (canvas.ariaLabel !== says) canvas.ariaLabel = says;
    if (this.#on === on) return;
    this.#on = on;
    canvas.classList.toggle("scrolls", on);
    canvas.role = on ? "application" : "img";
    if (on) canvas.tabIndex = 0;
    else canvas.removeAttribute("tabindex");
    this.#leave();
  }

  /** @param {MouseEvent} event @returns {Point} [pixel] */
  #pixel({ offsetX, offsetY }) {
    const scale = this.#canvas.clientWidth / this.#picture().width;
    return { x: offsetX / scale - 0.5, y: offsetY / scale - 0.5 };
  }

  /** @param {PointerEvent} event */
  #hover(event) {
    this.#hovers = this.#on;
    this.#cursor = null;
    if (this.#on) void this.#look(this.#pixel(event));
  }

  #leave() {
    this.#hovers = false;
    this.#cursor = this.#wanted = this.#found = null;
    this.#changed();
  }

  /** Ask for a place and for the newest of those that come meanwhile. @param {Point} at [pixel] */
  async #look(at) {
    this.#wanted = at;
    if (this.#asks) return;
    this.#asks = true;
    while (this.#wanted) {
      const wanted = this.#wanted;
      this.#wanted = null;
      const found = await this.#ask(wanted).catch(() => null); // the link chip says that there is none
      if (this.#hovers || this.#cursor) this.#found = found;
      this.#changed();
      if (this.#cursor && !this.#wanted && found) this.#panel.session.announce(inWords(found));
      await new Promise((done) => setTimeout(done, ASK_MS));
    }
    this.#asks = false;
  }

  /** @param {Point} at [pixel] */
  #ask = (at) => pressedFloor(at, this.#picture().stamp);

  /** @param {Point} at [pixel] */
  async #press(at) {
    if (!this.#on) return;
    await this.#panel.session.attempt(async () => {
      const { x_m: x, y_m: y, why } = await this.#ask(at);
      if (x === null || y === null) this.#panel.session.complain(why);
      else goTo(this.#canvas, this.#panel.session, { x, y }, null, "camera");
    });
  }

  /** Where the keyboard's cursor begins [pixel]. */
  get #begin() {
    const { width, height } = this.#picture();
    return { x: BEGIN.x * width, y: BEGIN.y * height };
  }

  /** Move the keyboard's cursor. @param {Point} to [pixel] */
  #move({ x, y }) {
    const { width, height } = this.#picture();
    this.#cursor = { x: Math.min(width - 1, Math.max(0, x)), y: Math.min(height - 1, Math.max(0, y)) };
    void this.#look(this.#cursor);
    this.#changed();
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    if (!this.#on || event.ctrlKey || event.altKey || event.metaKey) return;
    const { x, y } = this.#cursor ?? this.#begin;
    const to = stepped(event, { x, y: -y }, STEPS_PX);
    if (to) {
      event.preventDefault();
      this.#move({ x: to.x, y: -to.y });
    } else if (event.key === "Enter" && this.#cursor && this.#panel.session.state?.pending_command === null)
      void this.#press(this.#cursor);
  }

  /** @param {CanvasRenderingContext2D} brush @param {number} scale canvas pixels per picture pixel */
  draw(brush, scale) {
    const fine = devicePixelRatio || 1;
    if (this.#cursor) {
      const { x, y } = this.#cursor;
      for (const [colour, line] of BOTH) {
        [brush.strokeStyle, brush.lineWidth] = [colour, line * fine];
        drawCross(brush, { x: (x + 0.5) * scale, y: (y + 0.5) * scale }, 9 * fine);
      }
    }
    const { ring_px: ring, distance_m: distance } = this.#found ?? {};
    if (!ring?.length || !distance) return;
    drawRing(brush, ring, scale, "#ffffff");
    const words = metres(distance);
    brush.font = fontOf(LABEL_PX * fine);
    brush.textBaseline = "top";
    const [left, right, top] = [
      Math.min(...ring.map(([u]) => u)),
      Math.max(...ring.map(([u]) => u)),
      Math.min(...ring.map(([, v]) => v)),
    ];
    const [width, high] = [brush.measureText(words).width + 12 * fine, (LABEL_PX + 8) * fine];
    const [x, y] = [((left + right + 1) * scale - width) / 2, top * scale - high - 10 * fine];
    brush.fillStyle = "rgb(0 0 0 / 0.7)";
    brush.fillRect(x, y, width, high);
    brush.fillStyle = "#ffffff";
    brush.fillText(words, x + 6 * fine, y + 5 * fine);
  }
}

/** @type {[string, number][]} colour and width [px] of a light line on whatever the picture shows */
const BOTH = [
  [DARK, 5],
  ["#ffffff", 2],
];

/** @param {PressedFloor} found */
function inWords({ x_m: x, y_m: y, distance_m: distance, why }) {
  if (x === null || y === null || distance === null) return why;
  const where = `x ${fixed(x, 2)}, y ${fixed(y, 2)}`;
  return t("flat-map.where_metres_from_the_robot", { where, metres: metres(distance, 1) });
}

/**
 * The planned way, broad and strong where it is near, and the ring around its goal.
 * @param {CanvasRenderingContext2D} brush
 * @param {CameraOverlay} overlay
 * @param {number} scale canvas pixels per picture pixel
 */
export function drawWay(brush, { way = [], goal = [] }, scale) {
  const colour = colourOf(brush.canvas, "scene-plan");
  for (const part of way) {
    const [first, last] = [part[0], part.at(-1)];
    if (!first || !last) continue;
    const ribbon = ribbonOf(part, scale);
    const [from, to] = [first, last].map(([u, v]) => /** @type {const} */ ([(u + 0.5) * scale, (v + 0.5) * scale]));
    const fading = brush.createLinearGradient(...(from ?? [0, 0]), ...(to ?? [0, 0]));
    for (const [end, [, , distance]] of [first, last].entries()) fading.addColorStop(end, faded(colour, distance));
    [brush.strokeStyle, brush.lineWidth, brush.lineJoin] = [DARK, 2 * (devicePixelRatio || 1), "round"];
    brush.stroke(ribbon);
    brush.fillStyle = fading;
    brush.fill(ribbon);
  }
  if (goal.length) drawRing(brush, goal, scale, colour);
}

/** A way as wide as it is seen. @param {[number, number, number][]} part @param {number} scale */
function ribbonOf(part, scale) {
  const fine = devicePixelRatio || 1;
  const sides = part.map(([u, v, distance], index) => {
    const [[u0, v0], [u1, v1]] = [part[Math.max(0, index - 1)] ?? [u, v], part[index + 1] ?? [u, v]];
    const half = Math.max(LEAST_PX, Math.min(2 * NEAR_PX, NEAR_PX / distance)) * fine;
    const length = Math.hypot(u1 - u0, v1 - v0) || 1;
    const [across, down] = [(-half * (v1 - v0)) / length, (half * (u1 - u0)) / length];
    const [x, y] = [(u + 0.5) * scale, (v + 0.5) * scale];
    return { left: { x: x + across, y: y + down }, right: { x: x - across, y: y - down } };
  });
  const ribbon = new Path2D();
  trace(ribbon, [...sides.map(({ left }) => left), ...sides.map(({ right }) => right).reverse()], true);
  return ribbon;
}

/** @param {string} colour "rgb(…)" @param {number} distance [m] */
function faded(colour, distance) {
  const strength = Math.max(FAINTEST, 1 - distance / FADES_M);
  return colour.replace("rgb(", "rgba(").replace(")", `, ${strength.toFixed(2)})`);
}

/**
 * A ring on the floor, through points of it.
 * @param {CanvasRenderingContext2D} brush @param {[number, number][]} ring [pixel] @param {number} scale
 * @param {string} colour
 */
function drawRing(brush, ring, scale, colour) {
  const points = ring.map(([u, v]) => ({ x: (u + 0.5) * scale, y: (v + 0.5) * scale }));
  const path = new Path2D();
  for (const [index, { x, y }] of points.entries()) {
    const next = points[(index + 1) % points.length] ?? { x, y };
    const [middleX, middleY] = [(x + next.x) / 2, (y + next.y) / 2];
    if (index) path.quadraticCurveTo(x, y, middleX, middleY);
    else path.moveTo(middleX, middleY);
  }
  const [{ x, y } = { x: 0, y: 0 }, second = { x, y }] = points;
  path.quadraticCurveTo(x, y, (x + second.x) / 2, (y + second.y) / 2);
  for (const [stroke, line] of /** @type {const} */ ([
    [DARK, 5],
    [colour, 2.5],
  ])) {
    [brush.strokeStyle, brush.lineWidth] = [stroke, line * (devicePixelRatio || 1)];
    brush.stroke(path);
  }
}
