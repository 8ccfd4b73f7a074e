// What the status line says: the newest fact, never one that a newer one has overtaken. No clock, no page: time is given.

import { wordsOf } from "./api.js";
import { fixed, speed, turnRate } from "./format.js";

/** @typedef {import("./session.js").View} View */
/** @typedef {import("./session.js").Said} Said */
/** @typedef {import("./api.js").HistoryRow} HistoryRow */
/** @typedef {import("./hear/talk.js").Transcript} Transcript */
/**
 * @typedef {object} StatusLine
 * @property {string} icon
 * @property {string} words
 * @property {string} remark
 * @property {string} state "" when there is nothing to tell
 * @property {readonly string[]} meant what would have been understood
 * @property {boolean} [room] a voice in the room said it
 */
/** @typedef {{at: number, until: number, line: StatusLine}} Fact `at`, `until` [ms]: when it came about, and how long it is news */
/** @typedef {{words: string, why: string, at: number, meant: readonly string[]}} Refusal an answer whose row of the history is still to come */

export const STAYS_MS = 8000; // a result; the history keeps it
export const ASKS_MS = 20000; // a refusal that offers what may have been meant: time to read and press it
export const SLOW_MS = 3000; // of reading what was said, from which on that is told
export const GIVE_UP_MS = 8000;
const MOST = 50; // of what is remembered of rows
const STILL = 0.005; // [m/s], [rad/s]
const STOPS = "stop_moving";

/**
 * @param {string} icon
 * @param {string} words
 * @param {string} remark
 * @param {string} state
 * @param {readonly string[]} [meant]
 * @returns {StatusLine}
 */
const line = (icon, words, remark, state, meant = []) => ({ icon, words, remark, state, meant });

const LOST = line("unlinked", "Link lost", "The robot stops by itself.", "lost");
const STOPPED = line("stop", "Stopped", "", "stopped");
const UNSENT = line("unlinked", "No link", "STOP may not arrive; the robot stops by itself.", "lost");
const HALTED = line("halt", "Halted", "Nothing moves until the halt is reset.", "halted");
const RESET = line("done", "Reset, ready", "The reset moved nothing.", "done");
const UNHEARD = line("refused", "I did not get it", "Say it again, or type it.", "refused");

export class StatusLog {
  /** @type {Fact | null} the newest that happened */
  #event = null;
  /** @type {Map<"lost" | "halted" | "hand" | "reading" | "running", number>} what goes on, and since when [ms] */
  #since = new Map();
  #running = 0; // the command that runs
  #stoppedAt = -Infinity; // [ms] the newest stop or halt: how what began before it ended is no news
  /** @type {Map<number, number>} when [ms] commands began, as far as the page knows */
  #began = new Map();
  /** @type {Refusal[]} */
  #refused = [];
  /** @type {Map<number, string> | null} how every row of the history stood; null before it was read: old news is not told */
  #states = null;

  /**
   * A view: what goes on, and what has just begun or ended.
   * @param {View} view
   * @param {number} now [ms]
   */
  saw({ state, up }, now) {
    this.#goes("lost", !up && state !== null, now);
    const halted = state?.gate.state === "halted";
    if (up) {
      if (!halted && this.#since.has("halted")) this.#happen(now, RESET);
      if (halted && !this.#since.has("halted")) this.#stoppedAt = now;
      this.#goes("halted", halted, now);
    }
    const command = up && state?.command?.state === "running" ? state.command.id : 0;
    if (command !== this.#running) this.#since.delete("running");
    this.#running = command;
    if (command) this.#remember(command, now);
    this.#goes("running", command !== 0, this.#began.get(command) ?? now);
    this.#goes("hand", up && state?.gate.source === "jog", now);
    if (!up) this.#since.delete("reading");
    if (now - (this.#since.get("reading") ?? now) >= GIVE_UP_MS) {
      this.#since.delete("reading");
      this.#happen(now, UNHEARD);
    }
  }

  /**
   * STOP was pressed on this page.
   * @param {boolean} sent
   * @param {number} now [ms]
   */
  stopped(sent, now) {
    this.#since.delete("reading"); // it is void
    this.#stoppedAt = now;
    this.#happen(now, sent ? STOPPED : UNSENT);
  }

  /**
   * The button was let go: what was said is read now.
   * @param {number} now [ms]
   */
  reads(now) {
    this.#goes("reading", true, now);
  }

  /**
   * The console answered words of this page.
   * @param {Said} said
   * @param {number} now [ms]
   */
  answered({ text, answer, at }, now) {
    if (!answer.ok) {
      const row = answer.status > 0; // what was not sent stands in no history
      this.#refuse({ words: text, why: answer.detail ?? "", at, meant: answer.suggestions ?? [] }, row, now);
    } else if (answer.detail === "stop moving") {
      this.#stoppedAt = Math.max(this.#stoppedAt, at);
      this.#happen(at, STOPPED, now);
    } else {
      if (answer.id) this.#remember(answer.id, at);
      this.#happen(at, line("running", text, "", "sent"), now);
    }
  }

  /**
   * What our own microphone heard.
   * @param {Transcript} transcript
   * @param {number} now [ms]
   */
  heard({ final, accepted, heard_as, words, reason, suggestions, overtaken }, now) {
    if (accepted && heard_as === "stop moving") this.stopped(true, now);
    if (!final) return;
    const awaited = this.#since.delete("reading");
    if (accepted || overtaken) return;
    if (words) this.#refuse({ words, why: reason, at: now, meant: suggestions }, true, now);
    else if (awaited) this.#happen(now, { ...UNHEARD, remark: reason || UNHEARD.remark });
  }

  /**
   * The history: how commands ended. It may come late.
   * @param {readonly HistoryRow[]} rows newest first
   * @param {number} at [ms] when the page learned that there was news
   * @param {number} now [ms]
   * @returns {HistoryRow[]} those that have ended since, in the order in which they did
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

  /**
   * @param {HistoryRow} row
   * @param {number} at [ms]
   * @param {number} now [ms]
   */
  #end(row, at, now) {
    const answered = row.state === "refused" ? this.#takeRefusal(row) : null;
    const began = this.#began.get(row.id) ?? answered?.at ?? at;
    if (row.name === STOPS && row.state === "done") {
      this.#stoppedAt = Math.max(this.#stoppedAt, began);
      this.#happen(began, STOPPED, now);
    } else if (began < this.#stoppedAt) {
      this.#tellOfStop(row);
    } else {
      const room = row.source === "ears" && row.state === "refused";
      const result = ending(row.remark ? row : { ...row, remark: answered?.why ?? "" });
      this.#happen(answered?.at ?? at, { ...result, meant: answered?.meant ?? [], room }, now);
    }
  }

  /**
   * @param {View} view
   * @param {number} now [ms]
   * @param {StatusLine} ready what is said when there is nothing to tell
   * @returns {StatusLine}
   */
  line(view, now, ready) {
    const event = this.#event && now < this.#event.until ? this.#event : null;
    let [newest, at] = [event?.line ?? null, event?.at ?? -Infinity];
    for (const [what, since] of this.#since)
      if (since > at || !newest) [newest, at] = [this.#ongoing(what, view, now - since), since];
    if (newest) return newest;
    const { state, link, permission } = view;
    if (!state && link.is === "opening") return { ...ready, words: "Connecting…", remark: "" };
    return permission.may === "no" ? { ...ready, words: "", remark: permission.why } : ready;
  }

  /**
   * @param {"lost" | "halted" | "hand" | "reading" | "running"} what
   * @param {View} view
   * @param {number} elapsed [ms]
   * @returns {StatusLine}
   */
  #ongoing(what, { state, mine }, elapsed) {
    if (what === "lost" || !state) return LOST;
    if (what === "halted") return HALTED;
    if (what === "reading") {
      const slow = "This computer is slow at reading; type, or wait.";
      const remark = elapsed < SLOW_MS ? `${fixed(elapsed / 1000, 1)} s` : slow;
      return line("running", "Reading what you said…", remark, "reading");
    }
    if (what === "hand") {
      const { v_m_s: v, w_rad_s: w } = state.velocity;
      const who = mine || !state.lease.holder ? "Driving by hand" : `${state.lease.holder} drives by hand`;
      return line("wheel", who, Math.abs(v) < STILL && Math.abs(w) > STILL ? turnRate(w) : speed(v), "hand");
    }
    return line("running", state.command?.heard_as ?? "", state.command?.remark ?? "", "running");
  }

  /**
   * @param {"lost" | "halted" | "hand" | "reading" | "running"} what
   * @param {boolean} on
   * @param {number} at [ms]
   */
  #goes(what, on, at) {
    if (!on) this.#since.delete(what);
    else if (!this.#since.has(what)) {
      this.#since.set(what, at);
      if (this.#event && this.#event.at <= at) this.#event = null; // it does not come back when this is over
    }
  }

  /**
   * @param {number} at [ms] when it came about
   * @param {StatusLine} what
   * @param {number} [now] [ms]
   */
  #happen(at, what, now = at) {
    if (this.#event && at < this.#event.at) return;
    this.#event = { at, until: now + (what.meant.length ? ASKS_MS : STAYS_MS), line: what };
  }

  /**
   * @param {Refusal} refusal
   * @param {boolean} row whether a row of the history will repeat it
   * @param {number} now [ms]
   */
  #refuse({ words, why, at, meant }, row, now) {
    if (row) this.#refused = [...this.#refused, { words, why, at, meant }].slice(-MOST);
    if (at < this.#stoppedAt) return;
    this.#happen(at, line("refused", words, outcome("refused", why), "refused", meant), now);
  }

  /**
   * The answer that this row of the history repeats.
   * @param {HistoryRow} row
   */
  #takeRefusal({ words, source }) {
    const index = source === "ears" ? -1 : this.#refused.findIndex((each) => each.words === words);
    return index < 0 ? null : (this.#refused.splice(index, 1)[0] ?? null);
  }

  /** @param {HistoryRow} row that ended after a stop, and had begun before it */
  #tellOfStop(row) {
    const stop = this.#event;
    if (stop?.line.state !== "stopped" || row.state !== "cancelled") return;
    this.#event = { ...stop, line: { ...stop.line, remark: `${wordsOf(row)}: cancelled.` } };
  }

  /**
   * @param {number} id
   * @param {number} at [ms]
   */
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

/**
 * @param {string} state
 * @param {string} remark
 */
const outcome = (state, remark) => (remark ? `${state}. ${remark}` : state);
