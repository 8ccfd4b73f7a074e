// Create the picture source of a session: robot camera, webcam or files.
// Picture source: the newest decoded picture of the robot’s camera.

import { remembered } from "../ui/local-storage.js";
import { t } from "../ui/texts.js";
import * as api from "./api.js";
import { Uploads } from "./uploads.js";
import { Webcam } from "./webcam.js";

/** @import { Session } from "../net/session.js" */
/** @typedef {RobotCamera | Webcam | Uploads} PictureSource */

/**
 * @param {import("./types.js").Source} source
 * @param {string} id of the session
 * @param {import("./calibration-model.js").CalibrationModel} model receives each verdict
 * @param {import("../net/session.js").Session} session
 * @returns {PictureSource}
 */
export function pictureSource(source, id, model, session) {
  if (source === "webcam")
    return new Webcam(async (picture, stamp_s) => model.judge(await api.send(id, picture, { stamp_s })));
  if (source === "robot") return new RobotCamera(session);
  return new Uploads(async (picture, name) => {
    const verdict = await api.send(id, picture, { name });
    model.judge(verdict);
    return verdict;
  });
}

/**
 * True when pictures of this source are shown mirrored; by default those of a webcam.
 * @param {import("./types.js").Source | undefined} source
 */
export const isMirrored = (source) => remembered(`mirror.${source}`, source === "webcam" ? "true" : "false") === "true";

/**
 * @typedef {object} Frame a picture to be drawn
 * @property {CanvasImageSource} image
 * @property {number} width
 * @property {number} height
 * @property {string} key differs when the picture does
 * @property {number | null} stamp_s that a verdict names it by
 */

const QUIET_MS = 2500;

export class RobotCamera {
  /** @type {Frame | null} */
  frame = null;
  #session;
  #open = false;
  #decoding = false;
  #seenAt = -Infinity;

  /** @param {Session} session */
  constructor(session) {
    this.#session = session;
    session.on("picture", (picture) => void this.#take(picture));
  }

  open() {
    this.#open = true;
    this.#session.want(this, true);
  }

  close() {
    this.#open = false;
    this.#session.want(this, false);
  }

  /** @returns {string} why there is no fresh picture; "" when there is one */
  get why() {
    if (this.frame === null) return t("robot-camera-source.waiting_for_the_robot_s_first");
    return performance.now() - this.#seenAt > QUIET_MS ? t("robot-camera-source.no_new_pictures_arrive_from_the") : "";
  }

  /** @param {import("../net/session.js").Picture} picture */
  async #take(picture) {
    if (this.#decoding || !this.#open) return;
    this.#decoding = true;
    try {
      const image = await createImageBitmap(new Blob([picture.jpeg], { type: "image/jpeg" }));
      const old = this.frame?.image;
      const { width, height } = image;
      this.frame = { image, width, height, key: `robot ${picture.stamp}`, stamp_s: picture.stamp };
      if (old instanceof ImageBitmap) old.close();
      this.#seenAt = performance.now();
    } catch {
      // a damaged picture: the next one comes in a moment
    } finally {
      this.#decoding = false;
    }
  }
}
