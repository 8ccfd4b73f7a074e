// Create the picture source of a session: robot camera, webcam or files.

import { remembered } from "../ui/local-storage.js";
import * as api from "./api.js";
import { RobotCamera } from "./robot-camera-source.js";
import { Uploads } from "./uploads.js";
import { Webcam } from "./webcam.js";

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
