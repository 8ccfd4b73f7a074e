// Marks on the timeline of a recording: gaps known from its start, and what was noticed while it played.

import { duration, timeOfDay } from "./format.js";
import { t } from "./texts.js";

/** @import { HelloMessage as Hello, NoticeLine, State } from "../net/messages.js" */
/** @typedef {"gap" | "closure" | "lost" | "notice" | "command" | "speech" | "contact" | "trip" | "halt"} MarkKind */
/** @typedef {{at: number, kind: MarkKind, words: string}} Mark `at`: 0..1 of the recording */

const MOST = 300; // marks; beyond, the oldest go
const APART = 0.004; // of the recording: two marks of one kind nearer than that are one
/** @type {Readonly<Record<string, string>>} */
const NAMES = {
  command: t("timeline.command"),
  speech: t("timeline.words"),
  contact: t("timeline.contact"),
  trip: t("timeline.stopped_by_itself"),
  halt: t("timeline.halted"),
  lost: t("timeline.lost"),
  closure: t("timeline.a_place_was_recognised"),
};
const STEPS_S = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600];

export class Timeline {
  /** @type {Mark[]} */
  #marks = [];
  #notice = -1; // id of the newest that was looked at
  #lost = false;
  /** @type {Set<number>} */
  #closures = new Set();
  revision = 0; // rises with every change of the marks

  /** @returns {readonly Mark[]} in order of time */
  get marks() {
    return this.#marks;
  }

  /**
   * Begin with a recording.
   * @param {number} duration [s]
   * @param {readonly (readonly [number, number])[]} gaps without scans, from and to [s]
   */
  begin(duration, gaps) {
    this.#marks = [];
    this.#notice = -1;
    this.#lost = false;
    this.#closures.clear();
    this.revision += 1;
    for (const [from, to] of gaps)
      this.#add(from / duration, "gap", t("timeline.no_scans_for_value_s", { value: (to - from).toFixed(1) }));
  }

  /**
   * Marks that the recording itself knows; its gaps are known from the robot's card.
   * @param {readonly import("../net/rest.js").PlaybackMark[]} marks
   * @param {number} duration [s]
   */
  add(marks, duration) {
    for (const { t_s: time, kind, text } of marks)
      if (kind in NAMES)
        this.#add(
          time / duration,
          /** @type {MarkKind} */ (kind),
          text ? `${NAMES[kind]}: ${text}` : (NAMES[kind] ?? ""),
        );
  }

  /** @param {State} state */
  saw({ robot, floor, notices }) {
    const at = robot.progress ?? 0;
    for (const { id, state } of floor.closures) {
      if (state !== "accepted" || this.#closures.has(id)) continue;
      this.#closures.add(id);
      this.#add(at, "closure", t("timeline.a_place_was_recognised"));
    }
    if (floor.lost && !this.#lost) this.#add(at, "lost", floor.lost.words);
    this.#lost = floor.lost !== null;
    for (const { id, level, text } of notices) {
      if (id <= this.#notice) continue;
      this.#notice = id;
      if (level !== "info") this.#add(at, "notice", text);
    }
  }

  /** @param {number} at @param {MarkKind} kind @param {string} words */
  #add(at, kind, words) {
    if (this.#marks.some((mark) => mark.kind === kind && Math.abs(mark.at - at) < APART)) return;
    this.#marks = [...this.#marks.slice(-MOST + 1), { at: Math.min(1, Math.max(0, at)), kind, words }].sort(
      (one, other) => one.at - other.at,
    );
    this.revision += 1;
  }
}

/**
 * Times of a ruler: round steps, at most `most` of them after zero.
 * @param {number} duration [s]
 * @param {number} most
 * @returns {number[]} [s]
 */
export function ruler(duration, most) {
  const step = STEPS_S.find((seconds) => duration / seconds <= most) ?? 3600 * Math.ceil(duration / 3600 / most);
  return Array.from({ length: Math.floor(duration / step) + 1 }, (_, n) => n * step);
}

/**
 * When a notice came: by the wall clock, as in the history; in a recording its place there.
 * @param {NoticeLine} notice
 * @param {{hello: Hello | null, state: State | null}} shown now
 */
export function noticedAt({ at_s: at, stamp_s: stamp }, { hello, state }) {
  const { kind, duration_s: length } = hello?.robot ?? {};
  if (kind !== "LOG" || !state || !length) return timeOfDay(at);
  const clock = duration((state.robot.progress ?? 0) * length + stamp - state.stamp_s);
  return t("notice-list.clock_of_the_recording", { clock });
}
