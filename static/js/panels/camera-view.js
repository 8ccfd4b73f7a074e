// Element <camera-view>: camera picture with vertical edges, laser points, voice and person.
// What a driver reads off the large camera picture without looking away: heading, speed, how far it is to what stands ahead.

import { watchClearArea } from "../ui/clear-area.js";
import { FARTHEST, rangeColour } from "../ui/colormap.js";
import { icon, make, write } from "../ui/element.js";
import { age, degrees, fixed } from "../ui/format.js";
import { remember, remembered } from "../ui/local-storage.js";
import { Panel } from "../ui/panel.js";
import { PictureChip } from "../ui/picture-quality-chip.js";
import { drawCross, fontOf } from "../ui/place-drawing.js";
import { PARTS } from "../ui/sensed.js";
import { t } from "../ui/texts.js";
import { drawWay, PictureFloor } from "./picture-floor.js";

/** @import { CameraOverlay } from "../net/messages.js" */
/** @import { Picture, View } from "../net/session.js" */

const AHEAD_SHARE = 0.06; // of the picture's width on each side of its middle
const SEEN_S = 1.5; // that a distance is shown: a robot at rest sends the laser less often
const TURN_DEG = 360;
const MARK_DEG = 30;
const MARK_PX = 84; // between two of them on the tape

export class HeadUp {
  #heading = make("span.head-up-heading");
  #tape = make("div.head-up-tape");
  #speed = make("span.head-up-value");
  #ahead = make("span.head-up-value");
  #seen = "–";
  #seenAt = -Infinity; // [s] of the robot's clock

  element = make(
    "div.head-up",
    make("div.head-up-top", this.#tape, this.#heading),
    make("span.head-up-cross"),
    figure("speed", this.#speed, "m/s", t("head-up.speed")),
    figure("ahead", this.#ahead, "m", t("head-up.ahead")),
  );

  constructor() {
    for (let mark = -TURN_DEG; mark <= TURN_DEG; mark += MARK_DEG) {
      const words = String((TURN_DEG - mark) % TURN_DEG); // to the left is more: counter-clockwise
      const at = `calc(50% + ${(mark / MARK_DEG) * MARK_PX}px)`;
      const part = make("span.head-up-mark", { "aria-hidden": "true" }, words);
      part.style.left = at;
      this.#tape.append(part);
    }
  }

  /** @param {import("../net/messages.js").State} state @param {boolean} up */
  show({ stamp_s: stamp, pose, velocity, camera }, up) {
    const heading = ((((pose.heading_rad * 180) / Math.PI) % TURN_DEG) + TURN_DEG) % TURN_DEG;
    write(this.#heading, degrees(pose.heading_rad, 0));
    this.#tape.style.translate = `${((heading > TURN_DEG / 2 ? heading - TURN_DEG : heading) / MARK_DEG) * MARK_PX}px 0`;
    write(this.#speed, fixed(velocity.v_m_s, 2));
    const ahead = up && camera ? nearest(camera) : Infinity;
    if (ahead < Infinity) [this.#seen, this.#seenAt] = [fixed(ahead, 2), stamp];
    write(this.#ahead, stamp - this.#seenAt < SEEN_S ? this.#seen : "–");
  }
}

/** @param {import("../net/messages.js").CameraOverlay} camera @returns {number} [m], Infinity for nothing */
function nearest({ laser, width }) {
  const ahead = laser.filter(([u]) => Math.abs(u - width / 2) < AHEAD_SHARE * width);
  return Math.min(...ahead.map(([, , range]) => range));
}

/**
 * @param {string} name
 * @param {Element} value
 * @param {string} unit
 * @param {string} says
 */
function figure(name, value, unit, says) {
  const words = make("span.head-up-name", says);
  return make("div.head-up-figure", { "data-name": name }, words, make("span", value, ` ${unit}`));
}

const STALE_S = 0.5;
/** Pairs of MediaPipe's landmarks between which a limb is drawn. @type {[number, number][]} */
const LIMBS = [
  [7, 2],
  [2, 0],
  [0, 5],
  [5, 8],
  [11, 12],
  [11, 13],
  [13, 15],
  [12, 14],
  [14, 16],
  [11, 23],
  [12, 24],
  [23, 24],
  [23, 25],
  [25, 27],
  [27, 31],
  [24, 26],
  [26, 28],
  [28, 32],
];
const GIVE_UP_S = 3; // a recording without pictures: no empty frame
const LOOKED_S = 0.8; // a person is drawn for that long after the picture with them: networks answer late
const APART_S = 0.35; // an overlay older or newer than that belongs to another picture

class CameraView extends Panel {
  #canvas = make("canvas.picture", { role: "img", "aria-label": t("camera-view.camera_picture") });
  #age = make("span.tag.picture-age", { "data-tone": "stale" });
  #empty = make("p.camera-empty", icon("camera"), t("camera-view.waiting_for_the_first_picture"));
  #quality = new PictureChip();
  #headUp = new HeadUp();
  #edges = toggle("edges", t("camera-view.edges"), t("camera-view.edges_says"));
  #laser = toggle("laser", t("camera-view.laser"), t("camera-view.laser_says"));
  #way = toggle("way", t("camera-view.way"), t("camera-view.way_says"));
  #scale = make("p.ramp", make("span", "0 m"), make("span.ramp-bar"), make("span", `${FARTHEST} m`));
  /** @type {ImageBitmap | null} */
  #picture = null;
  #pictureStamp = 0;
  #pictureAt = -Infinity;
  #bornAt = performance.now();
  #decoding = false;
  #drawn = "";
  #floor = new PictureFloor(
    this.#canvas,
    this,
    () => ({ width: this.#picture?.width ?? 1, height: this.#picture?.height ?? 1, stamp: this.#pictureStamp }),
    () => (this.#drawn = ""),
  );

  /** @override */
  build() {
    this.classList.add("card");
    this.setAttribute("role", "region");
    this.setAttribute("aria-label", t("camera-view.camera"));
    this.append(
      make(
        "div.card-head",
        make("h2.card-title", t("camera-view.camera")),
        this.#quality.button,
        make("span.spring"),
        this.#edges,
        this.#laser,
        this.#way,
      ),
      make(
        "div.picture-box",
        this.#canvas,
        this.#headUp.element,
        this.#empty,
        this.#age,
        this.#scale,
        this.querySelector("swap-button"),
        this.#quality.panel,
      ),
    );
    watchClearArea(this, () => (this.#drawn = ""));
    this.session.on("picture", (picture) => void this.#take(picture));
    this.session.on("hello", () => (this.#bornAt = performance.now()));
    for (const button of [this.#edges, this.#laser, this.#way]) button.addEventListener("click", () => flip(button));
  }

  /** @override @param {View} view */
  show({ state, hello, up }) {
    const now = performance.now();
    const seen = this.#picture !== null;
    this.hidden = !seen && !hello?.robot.drives && now - this.#bornAt > GIVE_UP_S * 1000;
    const looked = this.hidden || this.offsetParent !== null; // while hidden without pictures, one may still arrive
    this.session.want(this, looked && document.visibilityState === "visible");
    this.#empty.hidden = seen;
    const paused = state?.robot.running === false && up;
    const old = seen && !paused ? (now - this.#pictureAt) / 1000 : 0;
    const stale = old > STALE_S || (seen && !up);
    this.classList.toggle("is-old", stale);
    this.#age.hidden = !stale;
    write(this.#age, t("camera-view.age_old", { age: age(old) }));
    this.#scale.hidden = !pressed(this.#laser) || !seen;
    this.#quality.show(seen ? state : null, stale);
    if (state && this.#headUp.element.offsetParent) this.#headUp.show(state, up);
    const shows = t("camera-view.camera_picture_length_vertical_edges_found", {
      length: state?.camera?.edges.length ?? 0,
    });
    this.#floor.allow(seen && up && hello?.robot.drives === true && this.#isLarge, shows);
    this.#draw(state?.camera ?? null, state?.ears?.voices[0] ?? null, state?.person ?? null);
  }

  /** True where no press on the picture exchanges it with the map. */
  get #isLarge() {
    const place = /** @type {HTMLElement} */ (this.parentElement);
    return (
      place.dataset["big"] === "camera" ||
      !(/** @type {HTMLElement | null} */ (this.querySelector(".swap"))?.offsetParent)
    );
  }

  /** @param {Picture} picture */
  async #take(picture) {
    const at = performance.now();
    if (this.#decoding) return;
    this.#decoding = true;
    try {
      const next = await createImageBitmap(new Blob([picture.jpeg], { type: "image/jpeg" }));
      this.#picture?.close();
      this.#picture = next;
      [this.#pictureStamp, this.#pictureAt] = [picture.stamp, at]; // of the shown picture
      this.#drawn = "";
    } catch {
      // a damaged picture: the next one comes in a moment
    } finally {
      this.#decoding = false;
    }
  }

  /**
   * @param {CameraOverlay | null} overlay
   * @param {import("../net/messages.js").VoiceHeard | null} voice
   * @param {import("../net/messages.js").PersonState | null} person
   */
  #draw(overlay, voice, person) {
    const picture = this.#picture;
    const width = this.#canvas.clientWidth;
    if (!picture || !width) return;
    const fits = overlay && Math.abs(overlay.stamp_s - this.#pictureStamp) < APART_S ? overlay : null;
    const [edges, laser, way] = [this.#edges, this.#laser, this.#way].map(pressed);
    const fresh = person && person.picture_age_s !== null && person.picture_age_s < LOOKED_S ? person : null;
    const seen = [voice?.columns_px, fresh?.value, fresh?.centre_px];
    const drawn = [this.#pictureStamp, fits?.stamp_s, edges, laser, way, width, devicePixelRatio, ...seen].join();
    if (drawn === this.#drawn) return;
    this.#drawn = drawn;

    const canvas = this.#canvas;
    const across = Math.round(width * devicePixelRatio);
    const down = Math.round((across * picture.height) / picture.width);
    if (canvas.width !== across || canvas.height !== down) [canvas.width, canvas.height] = [across, down];
    this.parentElement?.style.setProperty("--ratio", (picture.width / picture.height).toFixed(4));
    const brush = canvas.getContext("2d", { willReadFrequently: true }); // small: software drawing is faster
    if (!brush) return;
    brush.imageSmoothingQuality = "high";
    brush.drawImage(picture, 0, 0, across, down);
    const scale = across / picture.width;
    if (fits) {
      if (way) drawWay(brush, fits, scale);
      if (laser) drawLaser(brush, fits, scale);
      if (edges) drawEdges(brush, fits, scale);
      if (voice?.columns_px) drawVoice(brush, voice.columns_px, down, scale);
      if (fresh) drawPerson(brush, fresh, scale);
    }
    this.#floor.draw(brush, scale);
  }
}

/**
 * @param {CanvasRenderingContext2D} brush
 * @param {CameraOverlay} overlay
 * @param {number} scale canvas pixels per picture pixel
 */
function drawLaser(brush, overlay, scale) {
  const size = Math.max(2, 1.6 * scale);
  for (const [u, v, range] of overlay.laser) {
    brush.fillStyle = rangeColour(range);
    brush.fillRect((u + 0.5) * scale - size / 2, (v + 0.5) * scale - size / 2, size, size);
  }
}

/** @param {CanvasRenderingContext2D} brush @param {CameraOverlay} overlay @param {number} scale */
function drawEdges(brush, overlay, scale) {
  brush.lineCap = "round";
  for (const edge of overlay.edges) {
    const path = new Path2D();
    path.moveTo((edge.u0 + 0.5) * scale, (edge.v0 + 0.5) * scale);
    path.lineTo((edge.u1 + 0.5) * scale, (edge.v1 + 0.5) * scale);
    brush.setLineDash(edge.matched ? [] : [3 * scale, 3 * scale]);
    brush.strokeStyle = "rgb(0 0 0 / 0.55)";
    brush.lineWidth = (edge.matched ? 3.4 : 2.2) * Math.max(1, scale * 0.8);
    brush.stroke(path);
    brush.strokeStyle = edge.matched ? "#43d1e8" : "#ffffff";
    brush.lineWidth = (edge.matched ? 1.9 : 1) * Math.max(1, scale * 0.8);
    brush.stroke(path);
  }
  brush.setLineDash([]);
}

/**
 * Direction of a voice: a line and its 95 % band.
 * @param {CanvasRenderingContext2D} brush
 * @param {[number, number, number]} columns [pixel] left bound, middle, right bound
 * @param {number} down canvas pixels
 * @param {number} scale canvas pixels per picture pixel
 */
function drawVoice(brush, [left, middle, right], down, scale) {
  brush.fillStyle = "rgb(214 84 190 / 0.22)";
  brush.fillRect(left * scale, 0, (right - left) * scale, down);
  brush.fillStyle = "rgb(240 138 232)";
  brush.fillRect((middle + 0.5) * scale - 1, 0, 2, down);
}

/**
 * Person in three parts with their likelihoods; the cross is the centre of mass.
 * @param {CanvasRenderingContext2D} brush
 * @param {import("../net/messages.js").PersonState} person
 * @param {number} scale canvas pixels per picture pixel
 */
function drawPerson(brush, person, scale) {
  drawLandmarks(brush, person.landmarks_px, scale);
  const size = Math.max(13, 7 * scale);
  brush.font = fontOf(size);
  brush.textBaseline = "top";
  for (const part of person.parts) {
    if (part.likelihood === null) continue;
    const [left, top, right, bottom] = /** @type {[number, number, number, number]} */ (
      part.box_px.map((edge) => (edge + 0.5) * scale)
    );
    for (const [colour, line] of /** @type {[string, number][]} */ ([
      ["rgb(0 0 0 / 0.6)", 3.4],
      ["#ffd24a", 1.7],
    ])) {
      brush.strokeStyle = colour;
      brush.lineWidth = line * Math.max(1, scale * 0.6);
      brush.strokeRect(left, top, right - left, bottom - top);
    }
    const says = `${PARTS[part.name]} ${part.likelihood.toFixed(2)}`;
    const [x, y] = [Math.max(2, left + 2), Math.max(2, top + 2)];
    brush.fillStyle = "rgb(0 0 0 / 0.6)";
    brush.fillRect(x, y, brush.measureText(says).width + 4, size + 3);
    brush.fillStyle = "#ffd24a";
    brush.fillText(says, x + 2, y + 1);
  }
  if (!person.centre_px) return;
  const [u, v] = /** @type {[number, number]} */ (person.centre_px.map((place) => (place + 0.5) * scale));
  brush.strokeStyle = "#ffd24a";
  brush.lineWidth = Math.max(1.5, scale * 0.8);
  drawCross(brush, { x: u, y: v }, 4 * scale);
}

/**
 * Landmarks of a body, and the limbs between them.
 * @param {CanvasRenderingContext2D} brush
 * @param {import("../net/messages.js").PersonState["landmarks_px"]} marks
 * @param {number} scale canvas pixels per picture pixel
 */
function drawLandmarks(brush, marks, scale) {
  const places = marks.map((mark) => mark && [(mark[0] + 0.5) * scale, (mark[1] + 0.5) * scale]);
  const limbs = new Path2D();
  const joints = new Path2D();
  for (const [from, to] of LIMBS) {
    const [[x0, y0], [x1, y1]] = [places[from] ?? [], places[to] ?? []];
    if (x0 === undefined || y0 === undefined || x1 === undefined || y1 === undefined) continue;
    limbs.moveTo(x0, y0);
    limbs.lineTo(x1, y1);
  }
  const size = Math.max(1.4, 1.1 * scale);
  for (const [x, y] of places.map((place) => place ?? []))
    if (x !== undefined && y !== undefined) joints.rect(x - size / 2, y - size / 2, size, size);
  brush.lineCap = "round";
  brush.strokeStyle = "rgb(0 0 0 / 0.55)";
  brush.lineWidth = 3 * Math.max(1, scale * 0.6);
  brush.stroke(limbs);
  brush.strokeStyle = "#7ff0c0";
  brush.lineWidth = 1.5 * Math.max(1, scale * 0.6);
  brush.stroke(limbs);
  brush.fillStyle = "#ffffff";
  brush.fill(joints);
}

/** @param {string} name @param {string} says @param {string} title */
function toggle(name, says, title) {
  const on = remembered(`camera.${name}`, "true");
  return make("button.toggle", { "aria-pressed": on, "data-name": name, title }, says);
}

/** @param {HTMLElement} button */
const pressed = (button) => button.getAttribute("aria-pressed") === "true";

/** @param {HTMLElement} button */
function flip(button) {
  button.setAttribute("aria-pressed", String(!pressed(button)));
  remember(`camera.${button.dataset["name"]}`, String(pressed(button)));
}

customElements.define("camera-view", CameraView);
