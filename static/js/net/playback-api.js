// The recording that plays: what happened in it, and a part of it to take away.

import { address, call, post } from "./api.js";

/** @import { Part } from "./recordings-api.js" */
/** @import { PlaybackMark } from "./rest.js" */

/** @returns {Promise<PlaybackMark[]>} in order of time */
export async function marks() {
  return (await call("api/playback")).marks;
}

/** A part as a recording of its own. @param {Part} part @returns {Promise<import("./rest.js").FinishedRecording>} */
export const exportPart = async ({ from, to }) =>
  (await post("api/playback", { action: "export", from_s: from, to_s: to })).recording;

/** The address of a film of a part. @param {Part} part @param {"webp" | "gif"} form */
export const filmOfPart = ({ from, to }, form) => address(`api/playback/film.${form}?from_s=${from}&to_s=${to}`).href;
