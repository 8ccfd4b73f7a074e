// Client model of the speech quality page: all measurements, the selected one, and requests to the server.

import { address, wordedPath } from "../net/api.js";
import { RunsModel } from "../ui/page-model.js";
import { inLanguage, t } from "../ui/texts.js";

/** @import { QualityRunState as Run } from "../net/rest.js" */
/** @import { Session } from "../net/session.js" */

const ROOT = "api/speech-quality";
const ASK_MS = 700;

/** @param {string} id @param {number} row */
export const report = (id, row) => address(wordedPath(`${ROOT}/${encodeURIComponent(id)}/report/${row}`)).href;

/** @typedef {{distance_m: number, snr_db: number}} Place */

/** @extends {RunsModel<Run>} */
export class Runs extends RunsModel {
  whyNot = "";
  /** @type {readonly Place[]} where the form would measure now */
  planned = [];

  /** @param {Session} session */
  constructor(session) {
    super(session, ROOT, ROOT);
    this.poll(ASK_MS, () => this.running !== null);
  }

  /** @param {readonly Place[]} places */
  plan(places) {
    if (JSON.stringify(places) === JSON.stringify(this.planned)) return;
    this.planned = places;
    this.tell();
  }

  /** @override @param {{runs: Run[], why_not: string}} answer */
  take({ runs, why_not }) {
    [this.runs, this.whyNot] = [runs, inLanguage(why_not)];
  }

  /** @override @param {Run} run */
  endOf({ summary, reason }) {
    return t("runs.measured_summary", { summary: inLanguage(summary || reason) });
  }
}
