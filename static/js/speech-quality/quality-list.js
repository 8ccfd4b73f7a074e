// Element <quality-list>: stored measurements, newest first.

import { since } from "../calibration/active-calibration.js";
import { icon, make, mark } from "../ui/element.js";
import { Panel } from "../ui/panel.js";
import { t } from "../ui/texts.js";

/** @typedef {import("./runs.js").Runs} Runs */
/** @typedef {import("./runs.js").Run} Run */

const ICONS = { running: "running", done: "done", cancelled: "cancelled", failed: "failed" };

class QualityList extends Panel {
  /** @type {Runs | null} */
  #runs = null;
  #rows = make("ul", { class: "quality-rows" });
  #drawn = "";

  /** @param {Runs} runs */
  watch(runs) {
    this.#runs = runs;
    runs.onChange(() => this.#draw());
  }

  /** @override */
  build() {
    const head = make(
      "div",
      { class: "card-head" },
      make("h2", { class: "card-title" }, t("quality-list.measured_before")),
    );
    this.append(make("section", { class: "card", "aria-label": t("quality-list.measured_before") }, head, this.#rows));
    this.hidden = true;
  }

  #draw() {
    const all = this.#runs?.all ?? [];
    this.hidden = all.length === 0;
    const key = JSON.stringify([all.map(({ id, state, summary }) => [id, state, summary]), this.#runs?.shown?.id]);
    if (key === this.#drawn) return;
    this.#drawn = key;
    this.#rows.replaceChildren(...all.map((run) => this.#row(run)));
  }

  /** @param {Run} run */
  #row(run) {
    const { distances_m: far, phrases } = run.setup;
    const open = make(
      "button",
      { type: "button", class: "quality-open" },
      icon(ICONS[run.state]),
      make(
        "span",
        {},
        make("span", { class: "quality-name" }, run.summary || run.reason || run.doing || run.state),
        make(
          "span",
          { class: "note" },
          t("quality-list.join_m_phrases_phrases_who_since", {
            join: far.join(", "),
            phrases,
            who: run.who,
            since: since(run.at_s),
          }),
        ),
      ),
    );
    mark(open, "aria-current", run.id === this.#runs?.shown?.id ? "true" : null);
    open.addEventListener("click", () => this.#runs?.choose(run.id));
    const away = make(
      "button",
      { type: "button", class: "icon-button", "aria-label": t("quality-list.delete_this_measurement") },
      icon("trash"),
    );
    away.addEventListener("click", () => void this.#runs?.forget(run.id));
    return make("li", {}, open, this.#runs?.may && away);
  }
}

customElements.define("quality-list", QualityList);
