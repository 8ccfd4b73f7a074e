// Client model of the speech quality page: all measurements, the selected one, and requests to the server.

import { address, call, post } from "../net/api.js";
import { t } from "../ui/texts.js";

/** @typedef {import("../net/session.js").Session} Session */
/**
 * @typedef {object} Row one place
 * @property {number} distance_m
 * @property {number} snr_db
 * @property {string} refused why the place cannot be used; "" otherwise
 * @property {number} [commands]
 * @property {number} [commands_exact]
 * @property {number} [words]
 * @property {number} [erroneous_words_person]
 * @property {number} [erroneous_words_robot]
 * @property {number} [osqe_d]
 * @property {number | null} [osqe_r]
 * @property {string} [reason]
 * @property {string} [verdict]
 * @property {number} [stoi]
 */
/**
 * @typedef {object} Run
 * @property {string} id
 * @property {string} who
 * @property {number} at_s Unix time
 * @property {"running" | "done" | "cancelled" | "failed"} state
 * @property {string} doing
 * @property {string} reason
 * @property {number} progress 0..1
 * @property {string} summary "" before anything was measured
 * @property {Row[]} rows
 * @property {boolean[]} reports which rows have a page
 * @property {{phrases: number, distances_m: number[], snr_db: number[]}} setup
 */
/**
 * @typedef {object} RunRequest
 * @property {number[]} snr_db
 * @property {number} phrases
 * @property {number[]} [distances_m] from the robot; none: at the place
 * @property {number} [azimuth_rad]
 * @property {number} [x_m] of a place in the world
 * @property {number} [y_m]
 */

const ROOT = "api/speech-quality";
const ASK_MS = 700;

/** @returns {Promise<{runs: Run[], why_not: string}>} newest first */
export const list = () => call(ROOT);

/** @param {string} id @param {number} row */
export const report = (id, row) => address(`${ROOT}/${encodeURIComponent(id)}/report/${row}`).href;

export class Runs {
  /** @type {Run[] | null} newest first; null until they were read */
  all = null;
  whyNot = "";
  /** @type {string} of the one that is shown; "" for the newest */
  chosen = "";
  /** @type {Set<() => void>} */
  #listeners = new Set();

  /** @param {Session} session */
  constructor(session) {
    this.session = session;
    session.on("hello", () => void this.read());
    setInterval(() => this.running && document.visibilityState === "visible" && void this.read(), ASK_MS);
  }

  get running() {
    return this.all?.find((run) => run.state === "running") ?? null;
  }

  get shown() {
    return this.all?.find((run) => run.id === this.chosen) ?? this.all?.[0] ?? null;
  }

  /** True unless this user is a viewer. */
  get may() {
    return this.session.hello !== null && this.session.hello.you.role !== "viewer";
  }

  /** @param {() => void} listener */
  onChange(listener) {
    this.#listeners.add(listener);
  }

  /** @param {string} id */
  choose(id) {
    this.chosen = id;
    this.#tell();
  }

  async read() {
    const answer = await list().catch(() => null);
    if (!answer) return;
    const before = this.running;
    [this.all, this.whyNot] = [answer.runs, answer.why_not];
    const after = before && this.all.find((run) => run.id === before.id);
    if (after && after.state !== "running")
      this.session.announce(t("runs.measured_summary", { summary: after.summary || after.reason }));
    this.#tell();
  }

  /** @param {RunRequest} request */
  async begin(request) {
    await this.#tried(async () => this.choose((await post(ROOT, request)).id));
  }

  /** @param {string} id */
  async cancel(id) {
    await this.#tried(() => post(`${ROOT}/${encodeURIComponent(id)}/cancel`));
  }

  /** @param {string} id */
  async forget(id) {
    await this.#tried(() => call(`${ROOT}/${encodeURIComponent(id)}`, { method: "DELETE" }));
  }

  /** @param {() => Promise<unknown>} act */
  async #tried(act) {
    await this.session.attempt(act);
    await this.read();
  }

  #tell() {
    for (const listener of this.#listeners) listener();
  }
}
