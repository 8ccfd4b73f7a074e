// Element <picture-stage>: the large picture with its overlay.

import { isNew, make, mark } from "../ui/element.js";
import { t } from "../ui/texts.js";
import { hint } from "./board-hint.js";
import { drawCorners, drawGhost, drawLaser, drawWay } from "./overlay.js";
import { mirrored as inMirror } from "./words.js";

/** @import { Frame } from "./picture-source.js" */
/** @import { Calibration, Pixel, Verdict } from "./types.js" */

const FLASH_MS = 700;
const APART_S = 0.5; // a verdict on an older picture is not drawn on a newer one

export class PictureStage extends HTMLElement {
  #canvas = make("canvas.stage-picture", { role: "img", "aria-label": t("picture-stage.picture") });
  #timer = 0;

  connectedCallback() {
    if (!this.children.length) this.append(this.#canvas);
  }

  /**
   * @param {object} picture
   * @param {Frame | null} picture.frame
   * @param {Calibration} picture.calibration
   * @param {Verdict | null} picture.verdict the newest, whose corners are drawn
   * @param {boolean} picture.mirrored
   */
  show({ frame, calibration, verdict, mirrored }) {
    mark(this, "data-empty", frame === null);
    if (!frame || !this.clientWidth) return;
    const unit = Math.min(devicePixelRatio, 2);
    const scale = Math.min(this.clientWidth / frame.width, this.clientHeight / frame.height);
    const [width, height] = [Math.floor(frame.width * scale), Math.floor(frame.height * scale)];
    const taken = calibration.source === "upload"; // nobody can hold a board as advised in such a picture
    const advice = calibration.progress.ready || taken ? null : calibration.advice;
    const seen = fits(frame, verdict) ? verdict : null;
    const film = this.#film(frame, `${width}px`, `${height}px`, mirrored);
    if (!isNew(this, frame.key, seen?.number, seen?.stamp_s, advice?.words, width, unit, mirrored)) return;

    const canvas = this.#canvas;
    const [across, down] = [Math.round(width * unit), Math.round(height * unit)];
    if (canvas.width !== across || canvas.height !== down) {
      [canvas.width, canvas.height] = [across, down];
      [canvas.style.width, canvas.style.height] = [`${width}px`, `${height}px`];
    }
    const brush = canvas.getContext("2d", { willReadFrequently: true });
    if (!brush) return;
    if (film) brush.clearRect(0, 0, across, down);
    else paint(brush, frame.image, mirrored);

    const factor = across / (calibration.size?.[0] ?? frame.width);
    /** @param {Pixel} pixel @returns {Pixel} */
    const place = ([u, v]) => [mirrored ? across - (u + 0.5) * factor : (u + 0.5) * factor, (v + 0.5) * factor];
    const sheet = { brush, place, unit };
    const corners = seen?.corners ?? [];
    const way = advice && hint(corners, advice.corners, calibration.size?.[0] ?? frame.width);
    if (advice && verdict?.kind !== "background") drawGhost(sheet, advice, calibration.board.columns);
    if (seen?.laser) drawLaser(sheet, seen.laser);
    if (corners.length) drawCorners(sheet, corners, calibration.board.columns, seen?.kind ?? "");
    if (way && seen?.kind !== "counted") drawWay(sheet, way, (words) => (mirrored ? inMirror(words) : words));
    mark(
      canvas,
      "aria-label",
      corners.length
        ? t("picture-stage.picture_the_board_is_found_in")
        : t("picture-stage.picture_no_board_found_in_it"),
    );
  }

  /**
   * The browser shows a running video below the drawing: copying each frame would be slow.
   * @param {Frame} frame
   * @param {string} width
   * @param {string} height
   * @param {boolean} mirrored
   */
  #film({ image }, width, height, mirrored) {
    const film = image instanceof HTMLVideoElement ? image : null;
    const shown = this.querySelector("video");
    if (shown !== film) shown?.remove();
    if (film && film.parentElement !== this) this.prepend(film);
    if (film) [film.style.width, film.style.height] = [width, height];
    film?.classList.toggle("is-mirrored", mirrored);
    return film !== null;
  }

  flash() {
    this.classList.add("is-counted");
    clearTimeout(this.#timer);
    this.#timer = window.setTimeout(() => this.classList.remove("is-counted"), FLASH_MS);
  }
}

/** @param {CanvasRenderingContext2D} brush @param {CanvasImageSource} image @param {boolean} mirrored */
function paint(brush, image, mirrored) {
  const { width, height } = brush.canvas;
  brush.imageSmoothingQuality = "high";
  brush.save();
  if (mirrored) brush.transform(-1, 0, 0, 1, width, 0);
  brush.drawImage(image, 0, 0, width, height);
  brush.restore();
}

/** @param {Frame} frame @param {Verdict | null} verdict */
function fits(frame, verdict) {
  if (!verdict || frame.stamp_s === null || verdict.stamp_s === null) return verdict !== null;
  return Math.abs(frame.stamp_s - verdict.stamp_s) < APART_S;
}

customElements.define("picture-stage", PictureStage);
