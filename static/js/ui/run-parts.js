// What the pages of runs have in common: how far the run that is looked at is, and the list of them all.

import { cardHead, icon, iconButton, isNew, make, write } from "./element.js";
import { meter } from "./meter.js";
import { PagePanel } from "./panel.js";
import { t } from "./texts.js";

/** @typedef {{id: string, state: "running" | "done" | "cancelled" | "failed"}} Run */

export class RunProgress {
  #doing = make("p.run-doing");
  #bar = meter("div.meter.progress", { role: "progressbar", "aria-label": t("command-status.progress") });
  #cancel = make("button.button", icon("close"), t("run-parts.cancel"));
  element = make("div.run-going", { hidden: true }, this.#doing, this.#bar.element, this.#cancel);

  /** @param {() => import("./page-model.js").RunsModel<any>} model */
  constructor(model) {
    this.#cancel.addEventListener("click", () => {
      const { selected } = model();
      if (selected) void model().cancel(selected.id);
    });
  }

  /** @param {Run & {progress: number | null} | null} run @param {boolean} may cancel it @param {string} doing in words */
  show(run, may, doing) {
    const running = run?.state === "running";
    this.element.hidden = !running && !doing;
    this.#bar.element.hidden = this.#cancel.hidden = !running;
    this.#cancel.disabled = !may;
    write(this.#doing, doing);
    if (run) this.#bar.set(run.progress);
  }
}

/**
 * A card of all runs, the newest first: pressed, one is shown; beside it, what removes it.
 * @template {import("./page-model.js").RunsModel<any>} Model
 * @extends {PagePanel<Model>}
 */
export class RunList extends PagePanel {
  heading = "";
  #rows = make("ul.rows");

  /** @override */
  build() {
    this.append(make("section.card", { "aria-label": this.heading }, cardHead(this.heading), this.#rows));
    this.hidden = true;
  }

  /** @override */
  draw() {
    const { selected, may } = this.model;
    const runs = this.model.runs ?? [];
    this.hidden = runs.length === 0;
    const states = runs.map(({ id, state }) => [id, state]);
    if (isNew(this, states, selected?.id, may)) this.#rows.replaceChildren(...runs.map((run) => this.#row(run)));
  }

  /** What is said of a run, and of the button that deletes it. @param {any} _run @returns {{name: string, note: string, away: string}} */
  words(_run) {
    return { name: "", note: "", away: "" };
  }

  /** @param {Run} run */
  #row(run) {
    const { name, note, away } = this.words(run);
    const open = make(
      "button.row-open",
      { "aria-current": run.id === this.model.selected?.id ? "true" : null, onclick: () => this.model.choose(run.id) },
      icon(run.state),
      make("span", make("b", name), make("span.note", note)),
    );
    const remove = iconButton("trash", away, () => void this.model.remove(run.id), { title: t("map-card.delete") });
    return make("li", open, this.model.may && run.state !== "running" && remove);
  }
}
