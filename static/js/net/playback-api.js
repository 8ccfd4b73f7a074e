// What happened in the recording that plays.

import { call } from "./api.js";

/** @typedef {{t_s: number, kind: string, text: string}} PlaybackMark `t_s` from the start */

/** @returns {Promise<PlaybackMark[]>} in order of time */
export async function marks() {
  return (await call("api/playback")).marks;
}
