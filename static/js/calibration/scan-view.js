// Element <scan-view>: laser scan from above with the empty room and the beams on the board.

import { make, mark } from "../ui/element.js";
import { fontOf } from "../ui/place-drawing.js";
import { t } from "../ui/texts.js";
import { isDark } from "../ui/theme.js";

/** @import { ScanPicture } from "./types.js" */

const LEAST = 1.6; // [m] that are shown at least
const MOST = 5; // [m]

const DARK = { room: "#3d4f63", scan: "#a6b6c6", board: "#f08ae8", ring: "#1d2835", text: "#8597a9", robot: "#43d1e8" };
const LIGHT = {
  room: "#b4c2ce",
  scan: "#435567",
  board: "#a01c98",
  ring: "#dbe3ea",
  text: "#586b7d",
  robot: "#08748a",
};

export class ScanView extends HTMLElement {
  #canvas = make("canvas.scan-picture", { role: "img", "aria-label": t("scan-view.laser_scan") });
  #reach = 3;
  /** @type {ScanPicture | null} */
  #scan = null;
  #drawn = "";

  connectedCallback() {
    if (!this.children.length) this.append(this.#canvas);
  }

  /** @param {ScanPicture | null} scan points [m], x forward, y left */
  show(scan) {
    mark(this, "data-empty", scan === null);
    if (!scan || !this.clientWidth) return;
    const unit = Math.min(devicePixelRatio, 2);
    const drawn = [this.clientWidth, this.clientHeight, unit, isDark()].join();
    if (scan === this.#scan && drawn === this.#drawn) return;
    [this.#scan, this.#drawn] = [scan, drawn];
    const [across, down] = [Math.round(this.clientWidth * unit), Math.round(this.clientHeight * unit)];
    const canvas = this.#canvas;
    if (canvas.width !== across || canvas.height !== down) [canvas.width, canvas.height] = [across, down];
    const brush = canvas.getContext("2d", { willReadFrequently: true });
    if (!brush) return;
    const colours = isDark() ? DARK : LIGHT;
    const board = scan.board.map((index) => scan.points[index]).filter((point) => point !== undefined);
    this.#reach += 0.25 * (reach(scan, board) - this.#reach);
    const scale = Math.min((0.86 * down) / this.#reach, (0.5 * across) / (0.75 * this.#reach));
    /** @param {readonly [number, number]} point @returns {[number, number]} */
    const place = ([x, y]) => [across / 2 - y * scale, 0.9 * down - x * scale];

    brush.clearRect(0, 0, across, down);
    rings(brush, place, scale, unit, this.#reach, colours);
    dots(brush, scan.background.map(place), 2 * unit, colours.room);
    dots(brush, scan.points.map(place), 2.4 * unit, colours.scan);
    if (board.length) {
      line(brush, board.map(place), unit, colours.board);
      dots(brush, board.map(place), 5 * unit, colours.board);
    }
    const [x, y] = place([0, 0]);
    brush.fillStyle = colours.robot;
    brush.beginPath();
    brush.moveTo(x, y - 11 * unit);
    brush.lineTo(x + 8 * unit, y + 7 * unit);
    brush.lineTo(x - 8 * unit, y + 7 * unit);
    brush.fill();
    const found = board.length
      ? t("scan-view.the_board_is_met_by_length", { length: board.length })
      : t("scan-view.no_board_in_it_yet");
    mark(canvas, "aria-label", t("scan-view.laser_scan_from_above_found", { found }));
  }
}

/**
 * How far to look [m]: to the board and somewhat beyond, else over most of the room.
 * @param {ScanPicture} scan
 * @param {Array<readonly [number, number]>} board
 */
function reach(scan, board) {
  if (board.length) return Math.min(MOST, Math.max(LEAST, 1.9 * Math.max(...board.map(([x, y]) => Math.hypot(x, y)))));
  const ranges = [...scan.background, ...scan.points].map(([x, y]) => Math.hypot(x, y)).sort((a, b) => a - b);
  return Math.min(MOST, Math.max(LEAST, ranges[Math.floor(0.7 * ranges.length)] ?? LEAST));
}

/**
 * @param {CanvasRenderingContext2D} brush
 * @param {(point: readonly [number, number]) => [number, number]} place
 * @param {number} scale
 * @param {number} unit
 * @param {number} far [m]
 * @param {typeof DARK} colours
 */
function rings(brush, place, scale, unit, far, colours) {
  const [x, y] = place([0, 0]);
  brush.strokeStyle = colours.ring;
  brush.fillStyle = colours.text;
  brush.lineWidth = unit;
  brush.font = fontOf(13 * unit);
  brush.textAlign = "center";
  const step = far > 2.2 ? 1 : 0.5;
  for (let range = step; range < far * 1.6; range += step) {
    brush.beginPath();
    brush.arc(x, y, range * scale, Math.PI, 2 * Math.PI);
    brush.stroke();
    const top = y - range * scale - 4 * unit;
    if (top > 14 * unit) brush.fillText(`${range} m`, x, top);
  }
}

/**
 * @param {CanvasRenderingContext2D} brush
 * @param {Array<[number, number]>} places
 * @param {number} size
 * @param {string} colour
 */
function dots(brush, places, size, colour) {
  brush.fillStyle = colour;
  for (const [x, y] of places) brush.fillRect(x - size / 2, y - size / 2, size, size);
}

/**
 * @param {CanvasRenderingContext2D} brush
 * @param {Array<[number, number]>} places
 * @param {number} unit
 * @param {string} colour
 */
function line(brush, places, unit, colour) {
  const [first, last] = [places[0], places.at(-1)];
  if (!first || !last) return;
  brush.strokeStyle = colour;
  brush.globalAlpha = 0.35;
  brush.lineWidth = 12 * unit;
  brush.lineCap = "round";
  brush.beginPath();
  brush.moveTo(...first);
  brush.lineTo(...last);
  brush.stroke();
  brush.globalAlpha = 1;
}

customElements.define("scan-view", ScanView);
