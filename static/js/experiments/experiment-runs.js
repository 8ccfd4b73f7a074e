// Element <experiment-runs>: every run of an experiment, newest first.

import { day } from "../ui/format.js";
import { RunList } from "../ui/run-parts.js";
import { t } from "../ui/texts.js";

/** @extends {RunList<import("./runs-model.js").ExperimentRuns>} */
class ExperimentRunList extends RunList {
  /** @override */
  heading = t("experiment-result.runs");

  /** @override @param {import("../net/rest.js").ExperimentRunState} run */
  words(run) {
    const about = { runs: this.model.count(run), seed: run.seed, who: run.who, dayof: day(run.at_s) };
    return {
      name: run.title,
      note: t("experiment-result.runs_runs_seed_seed_who_dayof", about),
      away: t("experiment-result.delete_title_dayof", { title: run.title, dayof: about.dayof }),
    };
  }
}

customElements.define("experiment-runs", ExperimentRunList);
