// Where a session's pictures come from.

import { remembered } from "../memory.js";
import * as api from "./api.js";
import { RobotEye } from "./robot-eye.js";
import { Uploads } from "./uploads.js";
import { Webcam } from "./webcam.js";

/** @typedef {RobotEye | Webcam | Uploads} Eye */

/**
 * @param {import("./shape.js").Source} source
 * @param {string} id of the session
 * @param {import("./bench.js").Bench} bench hears of every verdict
 * @param {import("../session.js").Session} session
 * @returns {Eye}
 */
export function eyeFor(source, id, bench, session) {
  if (source === "webcam")
    return new Webcam(async (picture, stamp_s) => bench.judge(await api.send(id, picture, { stamp_s })));
  if (source === "robot") return new RobotEye(session);
  return new Uploads(async (picture, name) => {
    const verdict = await api.send(id, picture, { name });
    bench.judge(verdict);
    return verdict;
  });
}

/**
 * Whether its pictures are shown as in a mirror: one sees oneself in a webcam.
 * @param {import("./shape.js").Source | undefined} source
 */
export const isMirrored = (source) => remembered(`mirror.${source}`, source === "webcam" ? "true" : "false") === "true";
