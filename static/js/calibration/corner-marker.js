// Element <corner-marker>: the four extreme corners of a board, dragged to their places by hand (figure 3).

import { make } from "../ui/element.js";
import { t } from "../ui/texts.js";

/** @import { Frame } from "./picture-source.js" */
/** @import { Pixel } from "./types.js" */

/** @type {Pixel[]} shares of the picture at which the corners lie at first, clockwise */
const FIRST_PLACES = [
  [0.3, 0.3],
  [0.7, 0.3],
  [0.7, 0.7],
  [0.3, 0.7],
];
const LOSSLESS_PX = 3e6; // a larger picture is sent as a JPEG
const JPEG_QUALITY = 0.95;
const STEPS = /** @type {Readonly<Record<string, Pixel>>} */ ({
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
});
const LONG_STEP_PX = 10; // with Shift

export class CornerMarker extends HTMLElement {
  #canvas = make("canvas.marker-picture");
  #lines = make("div.marker-handles");
  #handles = FIRST_PLACES.map((_, index) =>
    make("button.marker-handle", {
      type: "button",
      "aria-label": t("corner-marker.corner_number", { number: index + 1 }),
    }),
  );
  /** @type {Pixel[]} [px] of the picture */
  #places = [];
  /** @type {(picture: Blob, corners: Pixel[]) => void} */
  marked = () => undefined;

  connectedCallback() {
    if (this.children.length) return;
    this.hidden = true;
    const use = make("button.button.primary", { onclick: () => this.#send() }, t("corner-marker.use_these_corners"));
    const leave = make("button.button", { onclick: () => (this.hidden = true) }, t("corner-marker.cancel"));
    this.#lines.append(...this.#handles);
    this.append(
      make("div.marker-stage", this.#canvas, this.#lines),
      make("p.marker-words", t("corner-marker.drag_the_four_corners")),
      make("div.marker-actions", use, leave),
    );
    for (const [index, handle] of this.#handles.entries()) this.#listen(handle, index);
  }

  /** @param {Frame} frame is copied: it stays as it was when the marking began */
  begin({ image, width, height }) {
    this.#canvas.width = width;
    this.#canvas.height = height;
    this.#canvas.getContext("2d")?.drawImage(image, 0, 0, width, height);
    this.#places = FIRST_PLACES.map(([u, v]) => [u * width, v * height]);
    this.hidden = false;
    this.#draw();
    this.#handles[0]?.focus();
  }

  /** @param {HTMLButtonElement} handle @param {number} index */
  #listen(handle, index) {
    handle.addEventListener("pointerdown", (event) => handle.setPointerCapture(event.pointerId));
    handle.addEventListener("pointermove", (event) => {
      if (!handle.hasPointerCapture(event.pointerId)) return;
      const box = this.#canvas.getBoundingClientRect();
      const scale = this.#canvas.width / box.width;
      this.#put(index, [(event.clientX - box.left) * scale, (event.clientY - box.top) * scale]);
    });
    handle.addEventListener("keydown", (event) => {
      const step = STEPS[event.key];
      const place = this.#places[index];
      if (!step || !place) return;
      event.preventDefault();
      event.stopPropagation(); // arrows drive elsewhere
      const length = event.shiftKey ? LONG_STEP_PX : 1;
      this.#put(index, [place[0] + length * step[0], place[1] + length * step[1]]);
    });
  }

  /** @param {number} index @param {Pixel} place */
  #put(index, [u, v]) {
    const { width, height } = this.#canvas;
    this.#places[index] = [Math.min(Math.max(u, 0), width - 1), Math.min(Math.max(v, 0), height - 1)];
    this.#draw();
  }

  #draw() {
    const { width, height } = this.#canvas;
    for (const [index, [u, v]] of this.#places.entries()) {
      const handle = this.#handles[index];
      if (handle) [handle.style.left, handle.style.top] = [`${(100 * u) / width}%`, `${(100 * v) / height}%`];
    }
  }

  #send() {
    const { width, height } = this.#canvas;
    const form = width * height > LOSSLESS_PX ? "image/jpeg" : "image/png";
    const corners = this.#places.map(([u, v]) => /** @type {Pixel} */ ([u - 0.5, v - 0.5])); // from rims to centres
    this.#canvas.toBlob((picture) => picture && this.marked(picture, corners), form, JPEG_QUALITY);
    this.hidden = true;
  }
}

customElements.define("corner-marker", CornerMarker);
