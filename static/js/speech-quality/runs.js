// Client model of the speech quality page: all measurements, the selected one, and requests to the server.

import { address, call } from "../net/api.js";
import { RunsModel } from "../ui/page-model.js";
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

const ROOT = "api/speech-quality";
const ASK_MS = 700;

/** @param {string} id @param {number} row */
export const report = (id, row) => address(`${ROOT}/${encodeURIComponent(id)}/report/${row}`).href;

/** @extends {RunsModel<Run>} */
export class Runs extends RunsModel {
  whyNot = "";

  /** @param {Session} session */
  constructor(session) {
    super(session, ROOT);
    session.on("hello", () => void this.read());
    setInterval(() => this.running && document.visibilityState === "visible" && void this.read(), ASK_MS);
  }

  /** @override */
  async read() {
    /** @type {{runs: Run[], why_not: string} | null} */
    const answer = await call(ROOT).catch(() => null);
    if (!answer) return;
    const before = this.running;
    [this.runs, this.whyNot] = [answer.runs, answer.why_not];
    const after = before && this.runs.find((run) => run.id === before.id);
    if (after && after.state !== "running")
      this.session.announce(t("runs.measured_summary", { summary: after.summary || after.reason }));
    this.tell();
  }
}
