// Client model of the speech quality page: all measurements, the selected one, and requests to the server.

import { address, call } from "../net/api.js";
import { RunsModel } from "../ui/page-model.js";
import { t } from "../ui/texts.js";

/** @import { QualityRunState as Run } from "../net/rest.js" */
/** @import { Session } from "../net/session.js" */

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
