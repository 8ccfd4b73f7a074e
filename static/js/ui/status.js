// Logic of the status line: the newest event that no later one has superseded. Time is injected.

import { wordsOf } from "../net/api.js";
import { fixed, speed, turnRate } from "./format.js";
import { t } from "./texts.js";

/** @import { HistoryRow } from "../net/rest.js" */
/** @import { Said, View } from "../net/session.js" */
/** @import { Transcript } from "../voice/audio-socket.js" */
/**
 * @typedef {object} StatusLine
 * @property {string} icon
 * @property {string} words
 * @property {string} remark
 * @property {string} state "" when there is nothing to report
 * @property {readonly string[]} suggestions commands that were possibly meant
 * @property {string | null} [code] of the console's sentence in the remark
 * @property {boolean} [room] true for a voice in the room
 */
/** @typedef {{at: number, until: number, line: StatusLine}} Fact `at`, `until` [ms]: when it happened, and until when it is shown */
/** @typedef {{words: string, why: string, at: number, suggestions: readonly string[], code: string | null}} Refusal a refusal whose history row has not arrived yet */

/** @typedef {"lost" | "halted" | "hand" | "listening" | "reading" | "running"} Ongoing */

export const STAYS_MS = 8000; // for a result; the history keeps it
export const ASKS_MS = 20000; // a refusal with suggestions: time to read and press one
export const SLOW_MS = 3000; // of waiting for a transcript, after which the line mentions it
export const RESULT_MS = 5000; // that the result of a command which is no longer under way is waited for
const MOST = 50; // remembered rows
const STILL = 0.005; // [m/s], [rad/s]
const TROUBLE = ["failed", "refused"];
const STOPS = "stop_moving";

/**
 * @param {string} icon
 * @param {string} words
 * @param {string} remark
 * @param {string} state
 * @returns {StatusLine}
 */
const line = (icon, words, remark, state) => ({ icon, words, remark, state, suggestions: [] });

const STARTING = line("running", t("status.starting"), t("status.awaits_the_first_scans"), "starting");
const LOST = line("unlinked", t("status.no_link"), t("status.commands_are_not_sent_until_it"), "lost");
const STOPPED = line("stop", t("status.stopped"), "", "stopped");
const UNSENT = line("unlinked", t("status.no_link"), t("status.stop_may_not_arrive_the_robot"), "failed");
const HALTED = line("halt", t("status.halted"), t("status.nothing_moves_until_the_halt_is"), "halted");
const RESET = line("done", t("status.reset_ready"), t("status.the_reset_moved_nothing"), "done");
const UNHEARD = line("refused", t("status.not_understood"), t("status.say_it_again_or_type_it"), "refused");

export class StatusLog {
  /** @type {Fact | null} newest event */
  #event = null;
  /** @type {Map<Ongoing, number>} ongoing states and their start [ms] */
  #since = new Map();
  #me = ""; // name of who is at this page
  #soFar = ""; // words of what is being read
  #running = 0; // id of the running command
  /** @type {{id: number, words: string, until: number} | null} the command that runs, or whose result is to come */
  #order = null;
  #stoppedAt = -Infinity; // [ms] newest stop or halt: results of commands that began before are not shown
  /** @type {Map<number, number>} start of commands [ms], where known */
  #began = new Map();
  /** @type {Refusal[]} */
  #refused = [];
  /** @type {Map<number, string> | null} state of each history row; null until it was read, so that old results are not shown */
  #states = null;

  /** Take a view: update ongoing states and detect what began or ended. @param {View} view @param {number} now [ms] */
  saw({ hello, state, up }, now) {
    this.#me = hello?.you.name ?? this.#me;
    this.#goes("lost", !up && state !== null, now);
    const halted = state?.gate.state === "halted";
    if (up) {
      if (!halted && this.#since.has("halted")) this.#happen(now, RESET);
      if (halted && !this.#since.has("halted")) this.#stoppedAt = now;
      this.#goes("halted", halted, now);
    }
    const running = up && state?.command?.state === "running" ? state.command : null;
    const command = running?.id ?? 0;
    if (command !== this.#running) this.#since.delete("running");
    this.#running = command;
    if (command) this.#remember(command, now);
    if (running) this.#order = { id: command, words: wordsOf(running), until: now + RESULT_MS };
    else if (!up || (this.#order && now > this.#order.until)) this.#order = null;
    const order = this.#order?.id ?? 0; // keeps its line until its result came
    this.#goes("running", order !== 0, this.#began.get(order) ?? now);
    this.#goes("hand", up && state?.gate.source === "jog", now);
    if (!up) this.#since.delete("reading");
  }

  /**
   * The talk button is held: these are the words so far; or it is not.
   * @param {string | null} words
   * @param {number} now [ms]
   */
  listens(words, now) {
    this.#soFar = words ?? this.#soFar;
    this.#goes("listening", words !== null, now);
  }

  /** The newest result or refusal was read, and leaves. */
  dismiss() {
    this.#event = null;
  }

  /** All that was said has been read: no words come any more. @param {number} now [ms] */
  wasRead(now) {
    if (this.#since.delete("reading")) this.#happen(now, UNHEARD);
  }

  /** STOP was pressed on this page. @param {boolean} sent @param {number} now [ms] */
  stopped(sent, now) {
    this.#since.delete("reading"); // STOP discards it
    this.#order = null;
    this.#stoppedAt = now;
    this.#happen(now, sent ? STOPPED : UNSENT);
  }

  /**
   * The talk button was released; the transcript is pending.
   * @param {number} now [ms]
   * @param {string} [words] so far
   */
  reads(now, words = "") {
    this.#soFar = words;
    this.#goes("reading", true, now);
  }

  /** @param {string} words so far of what is pending */
  readsSoFar(words) {
    this.#soFar = words;
  }

  /** Take the answer of the console to a command of this page. @param {Said} said @param {number} now [ms] */
  answered({ text, answer, at }, now) {
    if (!answer.ok) {
      const row = answer.status > 0; // a command that was not sent has no history row
      const { detail: why = "", suggestions = [], code = null } = answer;
      this.#refuse({ words: text, why: why ?? "", at, suggestions: suggestions ?? [], code }, row, now);
    } else if (answer.detail === "stop moving") {
      if (answer.id) this.#remember(answer.id, at); // its row may come after what was said next
      this.#stoppedAt = Math.max(this.#stoppedAt, at);
      this.#happen(at, STOPPED, now);
    } else {
      if (answer.id) this.#remember(answer.id, at);
      this.#happen(at, line("running", text, "", "sent"), now);
    }
  }

  /** Take a transcript of the microphone of this browser. @param {Transcript} transcript @param {number} now [ms] */
  heard({ final, accepted, heard_as, words, reason, suggestions, code = null, overtaken }, now) {
    if (accepted && heard_as === "stop moving") this.stopped(true, now);
    if (!final) return;
    const awaited = this.#since.delete("reading");
    if (accepted || overtaken) return;
    if (words) this.#refuse({ words, why: reason, at: now, suggestions, code }, true, now);
    else if (awaited) this.#happen(now, { ...UNHEARD, remark: reason || UNHEARD.remark });
  }

  /**
   * Take the history with the results of commands. It may arrive late.
   * @param {readonly HistoryRow[]} rows newest first
   * @param {number} at [ms] when the page learned of new rows
   * @param {number} now [ms]
   * @returns {HistoryRow[]} rows that have ended since, in that order
   */
  ended(rows, at, now) {
    const before = this.#states;
    this.#states = new Map(rows.map((row) => [row.id, row.state]));
    if (!before) return [];
    const news = rows.filter((row) => row.state !== before.get(row.id));
    const over = news.filter(({ state }) => state !== "running").sort((one, other) => end(one) - end(other));
    for (const { id, state } of news) if (state === "running") this.#remember(id, at);
    for (const row of over) this.#end(row, at, now);
    return over;
  }

  /** @param {HistoryRow} row @param {number} at [ms] @param {number} now [ms] */
  #end(row, at, now) {
    if (row.id === this.#order?.id) {
      this.#order = null;
      this.#since.delete("running");
    }
    if (row.id < this.#running && !TROUBLE.includes(row.state)) return; // what came after it is under way
    const answered = row.state === "refused" ? this.#takeRefusal(row) : null;
    if (row.state === "refused" && row.source !== "ears" && row.who !== this.#me) return; // another operator's
    const began = this.#began.get(row.id) ?? answered?.at ?? at;
    if (row.name === STOPS && row.state === "done") {
      this.#stoppedAt = Math.max(this.#stoppedAt, began);
      this.#happen(began, { ...STOPPED, remark: row.remark }, now);
    } else if (began < this.#stoppedAt) {
      this.#reportCancelled(row);
    } else {
      const room = row.source === "ears" && row.state === "refused";
      const result = ending(row.remark ? row : { ...row, remark: answered?.why ?? "" });
      const { suggestions = [], code = row.code ?? null } = answered ?? {};
      this.#happen(answered?.at ?? at, { ...result, suggestions, code, room }, now);
    }
  }

  /**
   * @param {View} view
   * @param {number} now [ms]
   * @param {StatusLine} ready what is said when there is nothing to report
   * @returns {StatusLine}
   */
  line(view, now, ready) {
    const over = !this.#event || now >= this.#event.until;
    const ofBefore = this.#since.has("listening") && this.#event?.line.state === "refused"; // someone speaks again
    const event = over || ofBefore ? null : this.#event;
    let [newest, at] = [event?.line ?? null, event?.at ?? -Infinity];
    for (const [what, since] of this.#since)
      if (since > at || !newest) [newest, at] = [this.#ongoing(what, view, now - since), since];
    if (newest) return newest;
    const { state, link, permission } = view;
    if (!state && link.is === "opening") return { ...STARTING, remark: t("status.awaits_the_console") };
    if (state?.slam.looking_around && state.robot.kind !== "LOG") return STARTING;
    return permission.may === "no" ? { ...ready, words: "", remark: permission.why } : ready;
  }

  /**
   * @param {Ongoing} what
   * @param {View} view
   * @param {number} elapsed [ms]
   * @returns {StatusLine}
   */
  #ongoing(what, { state, mine }, elapsed) {
    if (what === "lost" || !state) return LOST;
    if (what === "halted") return HALTED;
    if (what === "listening")
      return line("microphone", this.#soFar ? `“${this.#soFar} …”` : t("status.listening"), "", "listening");
    if (what === "reading") {
      const slow = t("status.speech_recognition_is_slow_on_this");
      const words = this.#soFar && `“${this.#soFar} …” `;
      const remark = words + (elapsed < SLOW_MS ? `${fixed(elapsed / 1000, 1)} s` : slow);
      return line("running", t("status.reading_what_you_said"), remark, "reading");
    }
    if (what === "hand") {
      const { v_m_s: v, w_rad_s: w } = state.velocity;
      const who =
        mine || !state.lease.holder
          ? t("status.driving_by_hand")
          : t("status.holder_drives_by_hand", { holder: state.lease.holder });
      return line("wheel", who, Math.abs(v) < STILL && Math.abs(w) > STILL ? turnRate(w) : speed(v), "hand");
    }
    const remark = (this.#running && state.command?.remark) || "";
    return line("running", this.#order?.words ?? "", remark, "running");
  }

  /** @param {Ongoing} what @param {boolean} on @param {number} at [ms] */
  #goes(what, on, at) {
    if (!on) this.#since.delete(what);
    else if (!this.#since.has(what)) {
      this.#since.set(what, at);
      if (this.#event && this.#event.at <= at) this.#event = null; // the event does not return afterwards
    }
  }

  /** @param {number} at [ms] when it happened @param {StatusLine} what @param {number} [now] [ms] */
  #happen(at, what, now = at) {
    if (this.#event && at < this.#event.at) return;
    this.#event = { at, until: now + (what.suggestions.length ? ASKS_MS : STAYS_MS), line: what };
  }

  /** @param {Refusal} refusal @param {boolean} row true when a history row will repeat it @param {number} now [ms] */
  #refuse({ words, why, at, suggestions, code }, row, now) {
    const shown = this.#event;
    if (row && shown && at < shown.at && shown.line.state === "refused" && shown.line.words === words) {
      this.#happen(shown.at, { ...shown.line, suggestions, code }, now); // its row came first
      return;
    }
    if (row) this.#refused = [...this.#refused, { words, why, at, suggestions, code }].slice(-MOST);
    if (at < this.#stoppedAt) return;
    this.#happen(at, { ...line("refused", words, outcome("refused", why), "refused"), suggestions, code }, now);
  }

  /** Take the refusal that this history row repeats. @param {HistoryRow} row */
  #takeRefusal({ words, source }) {
    const index = source === "ears" ? -1 : this.#refused.findIndex((each) => each.words === words);
    return index < 0 ? null : (this.#refused.splice(index, 1)[0] ?? null);
  }

  /** @param {HistoryRow} row that ended after a stop, and had begun before it */
  #reportCancelled(row) {
    const stop = this.#event;
    if (stop?.line.state !== "stopped" || row.state !== "cancelled") return;
    this.#event = { ...stop, line: { ...stop.line, remark: t("status.wordsof_cancelled", { wordsof: wordsOf(row) }) } };
  }

  /** @param {number} id @param {number} at [ms] */
  #remember(id, at) {
    if (this.#began.has(id)) return;
    this.#began.set(id, at);
    if (this.#began.size > MOST) this.#began.delete(Math.min(...this.#began.keys()));
  }
}

/** @param {HistoryRow} row when it ended, Unix time [s] */
const end = ({ at_s, duration_s }) => at_s + (duration_s ?? 0);

/** @param {HistoryRow} row @returns {StatusLine} */
const ending = (row) => line(row.state, wordsOf(row), outcome(row.state, row.remark), row.state);

/** @param {string} state @param {string} remark */
const outcome = (state, remark) => (remark ? `${t(`state.${state}`)}. ${remark}` : t(`state.${state}`));
