// Element <quality-list>: stored measurements, newest first.

import { since } from "../calibration/active-calibration.js";
import { RunList } from "../ui/run-parts.js";
import { t } from "../ui/texts.js";

/** @extends {RunList<import("./runs.js").Runs>} */
class QualityList extends RunList {
  /** @override */
  heading = t("quality-list.measured_before");

  /** @override @param {import("../net/rest.js").QualityRunState} run */
  words({ setup, who, at_s, summary, reason, doing, state }) {
    const about = { join: setup.distances_m.join(", "), phrases: setup.phrases, who, since: since(at_s) };
    return {
      name: summary || reason || doing || state,
      note: t("quality-list.join_m_phrases_phrases_who_since", about),
      away: t("quality-list.delete_this_measurement"),
    };
  }
}

customElements.define("quality-list", QualityList);
