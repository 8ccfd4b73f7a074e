// HTTP client for recordings: start, stop, keep what just happened, and the list.
// The recording that plays: what happened in it, and a part of it to take away.

import { translate } from "../ui/texts.js";
import { address, call, post, send } from "./api.js";

/** @import { FinishedRecording as Recording, PlaybackMark } from "./rest.js" */
/** @typedef {{from: number, to: number}} Part [s] from the start */

const ROOT = "api/recordings";

/** @param {string} name */
const one = (name) => `${ROOT}/${encodeURIComponent(name)}`;

/** @returns {Promise<Recording[]>} newest first, with the one that runs */
export async function list() {
  /** @type {Recording[]} */
  const recordings = (await call(ROOT)).recordings;
  for (const recording of recordings) translate(recording, "cause");
  return recordings;
}

/** @returns {Promise<{name: string}>} */
export const start = () => post(`${ROOT}/start`, {});

/** @returns {Promise<Recording>} */
export const stop = () => post(`${ROOT}/stop`);

/** @param {number} seconds @returns {Promise<Recording>} */
export const keep = (seconds) => post(`${ROOT}/keep`, { seconds });

/** Keep a recording that was made elsewhere. @param {File} file @returns {Promise<{url: string}>} what opens it */
export const take = (file) =>
  call(one(file.name), { method: "PUT", body: file, headers: { "content-type": "application/octet-stream" } });

/** Make a sample, or find it. @param {string} sample @returns {Promise<{url: string}>} what opens it */
export const make = (sample) => post(`${ROOT}/samples/${sample}`);

/** @param {string} name @param {{name?: string, note?: string}} fresh */
export const change = (name, fresh) => send(one(name), "PATCH", fresh);

/** @param {string} name */
export const remove = (name) => call(one(name), { method: "DELETE" });

/** A small picture of it, null where its camera saw nothing. @param {Recording} recording */
export const pictureOf = ({ name, started_s: started, messages }) =>
  messages["/camera/image/compressed"] ? address(`${one(name)}/picture?of=${started}`).href : null;

/** A part of it as a recording of its own; both times [s] from its start. @param {string} name @param {Part} part */
export const cut = (name, { from, to }) => post(`${one(name)}/export`, { from_s: from, to_s: to });

/** A film of a part: map and camera. @param {string} name @param {Part} part @param {"webp" | "gif"} form */
export const filmOf = (name, { from, to }, form) => address(`${one(name)}/film.${form}?from_s=${from}&to_s=${to}`).href;

/** @param {string} name */
export const fileOf = (name) => address(one(name)).href;

/** @returns {Promise<PlaybackMark[]>} in order of time */
export async function marks() {
  return (await call("api/playback")).marks;
}

/** A part as a recording of its own. @param {Part} part @returns {Promise<import("./rest.js").FinishedRecording>} */
export const exportPart = async ({ from, to }) =>
  (await post("api/playback", { action: "export", from_s: from, to_s: to })).recording;

/** The address of a film of a part. @param {Part} part @param {"webp" | "gif"} form */
export const filmOfPart = ({ from, to }, form) => address(`api/playback/film.${form}?from_s=${from}&to_s=${to}`).href;
