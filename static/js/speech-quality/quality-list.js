// Element <quality-list>: stored measurements, newest first.

import { since } from "../calibration/active-calibration.js";
import { icon, isNew, make } from "../ui/element.js";
import { PagePanel } from "../ui/panel.js";
import { runRow } from "../ui/run-row.js";
import { t } from "../ui/texts.js";

/** @import { QualityRunState as Run } from "../net/rest.js" */
/** @import { Runs } from "./runs.js" */

/** @extends {PagePanel<Runs>} */
class QualityList extends PagePanel {
  #rows = make("ul.rows");

  /** @override */
  build() {
    const head = make("div.card-head", make("h2.card-title", t("quality-list.measured_before")));
    this.append(make("section.card", { "aria-label": t("quality-list.measured_before") }, head, this.#rows));
    this.hidden = true;
  }

  /** @override */
  draw() {
    const all = this.model.runs ?? [];
    this.hidden = all.length === 0;
    if (
      !isNew(
        this,
        all.map(({ id, state, summary }) => [id, state, summary]),
        this.model.selected?.id,
      )
    )
      return;
    this.#rows.replaceChildren(...all.map((run) => this.#row(run)));
  }

  /** @param {Run} run */
  #row(run) {
    const { distances_m: far, phrases } = run.setup;
    const about = { join: far.join(", "), phrases, who: run.who, since: since(run.at_s) };
    const away = make(
      "button.icon-button",
      { "aria-label": t("quality-list.delete_this_measurement"), onclick: () => void this.model.remove(run.id) },
      icon("trash"),
    );
    const words = {
      drawing: run.state,
      name: run.summary || run.reason || run.doing || run.state,
      note: t("quality-list.join_m_phrases_phrases_who_since", about),
    };
    return runRow(this.model, run, words, away);
  }
}

customElements.define("quality-list", QualityList);
