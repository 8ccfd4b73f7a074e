// Client model of the recordings page: the list, which is read again when the state says that it has changed.

import { openInstead, saveMap } from "../connect/opening.js";
import * as recordings from "../net/recordings-api.js";
import { day, duration, size } from "../ui/format.js";
import { PageModel } from "../ui/page-model.js";
import { inLanguage, t } from "../ui/texts.js";

const CLOCK_SET_S = 946_684_800; // the year 2000: what says less is a clock that was never set

/** @import { Session } from "../net/session.js" */
/** @import { FinishedRecording as Recording } from "../net/rest.js" */

export class RecordingsModel extends PageModel {
  /** @type {Recording[] | null} newest first; null until they were read */
  recordings = null;
  #revision = -1;

  /** @param {Session} session */
  constructor(session) {
    super(session);
    session.on("hello", () => {
      this.#revision = -1;
    });
    session.on("heard", () => this.#watch());
  }

  /** @override @param {boolean} shown */
  follow(shown) {
    this.#revision = -1;
    this.shown = shown;
    this.#watch();
  }

  #watch() {
    const { hello, state } = this.session;
    const revision = state?.recording?.revision ?? 0;
    if (!this.shown || !hello || !state || revision === this.#revision) return;
    this.#revision = revision;
    void this.read();
  }

  /** @override */
  read() {
    return this.reading(async () => {
      this.recordings = await recordings.list();
    });
  }

  /** @param {string} name @param {{name: string, note: string}} fresh @returns {Promise<boolean>} whether it was done */
  change(name, fresh) {
    return this.#tried("", () => recordings.change(name, fresh));
  }

  /** @param {string} name @param {recordings.Part} part */
  cut(name, part) {
    return this.#tried(t("recordings-list.part_is_written"), () => recordings.cut(name, part));
  }

  /** @param {string} name */
  remove(name) {
    return this.#tried("", () => recordings.remove(name));
  }

  /**
   * Open it instead of the robot, and play it; the console starts again with it, and drives nothing.
   * @param {Recording} one
   * @param {boolean} save the map first
   */
  play(one, save) {
    const url = urlOf(one);
    return this.#tried(t("connection-model.opening_url", { url: one.name }), async () => {
      if (save) await saveMap(this.session);
      await openInstead(this.session, url, true);
    });
  }

  /** @param {string} doing @param {() => Promise<unknown>} act */
  #tried(doing, act) {
    return this.during(doing, async () => {
      await act();
      await this.read();
    });
  }
}

/** The URL that opens it. @param {Recording} recording */
export const urlOf = ({ file }) => `log:${file}`;

/** What is said of a recording below its name: when, how long, how large, which robot. @param {Recording} recording */
export const about = ({ started_s: started, seconds, bytes, robot }) =>
  [started > CLOCK_SET_S && day(started), seconds > 0 && duration(seconds), size(bytes), inLanguage(robot)]
    .filter(Boolean)
    .join(" · ");

/**
 * The state of a recording: only what is whole can be played and taken away, and what runs is not changed.
 * @param {Recording} recording
 * @param {string | null} running name of the one that runs
 * @returns {"runs" | "whole" | "cut" | "unfinished"}
 */
export function stateOf({ name, complete, seconds, code }, running) {
  if (name === running) return "runs";
  if (complete) return "whole";
  return code === "recording.recovering" && seconds === 0 ? "unfinished" : "cut";
}
