// Element <people-stage>: live picture during an enrollment, and briefly the findings in the one just taken.
// Drawing of a person in a picture: contour, head, torso and feet.

import { RobotCamera } from "../calibration/picture-source.js";
import { Webcam } from "../calibration/webcam.js";
import { icon, make, mark, svg, write } from "../ui/element.js";
import { PARTS } from "../ui/sensed.js";
import { t } from "../ui/texts.js";
import { pictureOf } from "./enrollment-model.js";

/** @import { JudgedPictureState as Judged } from "../net/rest.js" */

/**
 * The picture with everything drawn on it.
 * @param {string} id of the enrollment
 * @param {Judged} judged
 * @param {string} says
 */
export function sketched(id, judged, says) {
  const [width, height] = judged.size;
  const drawing = svg("svg", { viewBox: `0 0 ${width} ${height}`, class: "sketch", "aria-hidden": "true" });
  if (judged.outline.length)
    drawing.append(
      svg("polygon", { points: judged.outline.map(([u, v]) => `${u},${v}`).join(" "), class: "sketch-outline" }),
    );
  for (const { name, box_px: box } of judged.parts) {
    const [left, top, right, bottom] = box;
    drawing.append(svg("rect", { x: left, y: top, width: right - left, height: bottom - top, class: "sketch-part" }));
    const label = svg("text", {
      x: right + 0.012 * height,
      y: (top + bottom) / 2,
      class: "sketch-name",
      "font-size": 0.04 * height,
    });
    label.textContent = PARTS[name] ?? name;
    drawing.append(label);
  }
  const picture = make("img", {
    src: pictureOf(id, judged.number),
    alt: says,
    width: String(width),
    height: String(height),
  });
  return make("div.sketched", { "data-good": judged.good }, picture, drawing);
}

/** @typedef {"robot" | "webcam" | "upload"} Source */

const LOOK_MS = 3500;
const LARGEST = 1280; // [px] side of an uploaded picture
const QUALITY = 0.92;

export class PeopleStage extends HTMLElement {
  #canvas = make("canvas.stage-live");
  #why = make("p.stage-why");
  #count = make("p.stage-count", { "aria-live": "assertive" });
  #seen = make("div.stage-seen", { hidden: true });
  #again = make("button.button", icon("again"), t("people-stage.try_again"));
  /** @type {Source} */
  #source = "robot";
  /** @type {RobotCamera | null} */
  #robot = null;
  #webcam = new Webcam(async () => null);
  #open = false;
  #until = 0;
  #shown = "";

  connectedCallback() {
    if (this.children.length) return;
    this.#webcam.paused = true;
    this.#again.addEventListener("click", () => void this.#webcam.open());
    this.append(this.#canvas, this.#seen, make("div.stage-empty", this.#why, this.#again), this.#count);
  }

  /** @param {Source} source @param {import("../net/session.js").Session} session */
  open(source, session) {
    if (this.#open && source === this.#source) return;
    this.close();
    this.#open = true;
    this.#source = source;
    this.#robot ??= new RobotCamera(session);
    if (source === "robot") this.#robot.open();
    if (source === "webcam") void this.#webcam.open();
  }

  close() {
    if (!this.#open) return;
    this.#open = false;
    this.#robot?.close();
    this.#webcam.close();
    this.querySelector("video")?.remove();
  }

  get ready() {
    return this.#source !== "upload" && this.#camera?.frame !== null;
  }

  get #camera() {
    return this.#source === "robot" ? this.#robot : this.#webcam;
  }

  /** @returns {Blob | null} what the webcam sees now; null: the robot takes its picture itself */
  snapshot() {
    return this.#source === "webcam" ? this.#webcam.snapshot() : null;
  }

  /** @param {string} words large over the picture; "" for none */
  count(words) {
    write(this.#count, words);
  }

  /** @param {string} id of the enrollment @param {Judged | null} judged the newest */
  judge(id, judged) {
    const key = judged ? `${id} ${judged.number}` : "";
    if (key === this.#shown) return;
    this.#shown = key;
    this.#seen.replaceChildren(...(judged ? [sketched(id, judged, judged.words)] : []));
    this.#until = judged ? performance.now() + LOOK_MS : 0;
    this.draw();
  }

  draw() {
    const upload = this.#source === "upload";
    const looking = this.#shown !== "" && (upload || performance.now() < this.#until);
    this.#seen.hidden = !looking;
    const frame = upload ? null : (this.#camera?.frame ?? null);
    const film = frame?.image instanceof HTMLVideoElement ? frame.image : null;
    if (film && film.parentElement !== this) this.prepend(film);
    this.#canvas.hidden = film !== null || frame === null;
    mark(this, "data-mirrored", film !== null);
    const why = upload ? t("people-stage.drop_pictures_here_or_choose_them") : (this.#camera?.why ?? "");
    write(this.#why, looking || (frame && !why) ? "" : why);
    this.#again.hidden = looking || this.#source !== "webcam" || !this.#webcam.refused;
    if (!frame || film) return;
    const { image, width, height } = frame;
    if (this.#canvas.width !== width || this.#canvas.height !== height)
      [this.#canvas.width, this.#canvas.height] = [width, height];
    this.#canvas.getContext("2d")?.drawImage(image, 0, 0, width, height);
  }
}

/**
 * Decode a picture file, rotate it upright and limit its size. Throws when it is not a picture.
 * @param {File} file
 * @returns {Promise<Blob>}
 */
export async function prepared(file) {
  const image = await createImageBitmap(file, { imageOrientation: "from-image" }).catch(() => null);
  if (!image) throw new Error(`${file.name} is no picture that this browser can read. JPEG or PNG will do.`);
  const scale = Math.min(1, LARGEST / Math.max(image.width, image.height));
  const canvas = make("canvas");
  [canvas.width, canvas.height] = [Math.round(image.width * scale), Math.round(image.height * scale)];
  canvas.getContext("2d")?.drawImage(image, 0, 0, canvas.width, canvas.height);
  image.close();
  const packed = await new Promise((/** @type {(blob: Blob | null) => void} */ resolve) =>
    canvas.toBlob(resolve, "image/jpeg", QUALITY),
  );
  if (!packed) throw new Error(`${file.name} could not be read.`);
  return packed;
}

customElements.define("people-stage", PeopleStage);
