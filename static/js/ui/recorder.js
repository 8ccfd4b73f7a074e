// The recorder as the page shows it: what runs, what can be kept, and why this person cannot now.

import * as recordings from "../net/recordings-api.js";
import { duration, size } from "./format.js";
import { t } from "./texts.js";

/** @import { FinishedRecording } from "../net/rest.js" */
/** @import { Session, View } from "../net/session.js" */
/**
 * @typedef {object} RecorderView
 * @property {boolean} runs
 * @property {string} time "1:05" while it runs, else ""
 * @property {string} size "12 MB"
 * @property {string} whyNot a sentence, where this person can neither start nor stop it; else ""
 * @property {boolean} holds the last part of a drive is held in memory, or would be
 * @property {string} held length of that part, "1:20"; "" for none
 * @property {string} whyNotKept a sentence, where it cannot be kept now; else ""
 */

const SHORTEST_S = 1; // that is worth a file

/** @param {Pick<View, "hello" | "state" | "up">} view @returns {RecorderView} */
export function recorderOf({ hello, state, up }) {
  const recording = state?.recording ?? null;
  const runs = recording?.name != null;
  const held = recording && recording.ring_s >= SHORTEST_S ? duration(recording.ring_s) : "";
  const away = up
    ? recording
      ? ""
      : t("recorder.this_is_a_recording_already")
    : t("permission.the_link_to_the_console_is");
  const watches = hello?.you.role === "viewer" ? t("recorder.only_an_operator_records") : "";
  return {
    runs,
    time: runs ? duration(recording?.seconds ?? 0) : "",
    size: runs ? size(recording?.bytes ?? 0) : "",
    whyNot: away || watches,
    holds: recording !== null && recording.ring_limit_s > 0,
    held,
    whyNotKept: away || (held ? "" : t("recorder.nothing_to_keep_yet")),
  };
}

/** Start or stop; the answer leads to the list. @param {Session} session */
export function toggle(session) {
  const { runs, whyNot } = recorderOf(session.view);
  if (whyNot) return refuse(session, whyNot);
  if (!runs) return session.attempt(recordings.start);
  return session.attempt(async () => showFinished(session, "recorder.name_is_recorded", await recordings.stop()));
}

/** Keep what just happened; the answer leads to the list. @param {Session} session */
export function keep(session) {
  const { whyNotKept } = recorderOf(session.view);
  if (whyNotKept) return refuse(session, whyNotKept);
  const seconds = session.state?.recording?.ring_limit_s ?? 0;
  return session.attempt(async () => showFinished(session, "recorder.kept_as_name", await recordings.keep(seconds)));
}

/** @param {Session} session @param {string} why */
function refuse(session, why) {
  session.complain(why);
  return Promise.resolve(false);
}

/** @param {Session} session @param {string} key of the sentence @param {FinishedRecording} recording */
export function showFinished(session, key, { name, seconds, bytes }) {
  const text = t(key, { name, time: duration(seconds), size: size(bytes) });
  if (document.body.dataset["page"] === "recordings") return session.announce(text); // the list shows it
  session.tell("offer", { text, words: t("recorder.show"), event: "show-recordings" });
}
