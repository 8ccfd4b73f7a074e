// Element <experiment-list>: every experiment, what it reproduces, how long it takes, and its start.

import { icon, make, mark, numberField, onSubmit, write } from "../ui/element.js";
import { date } from "../ui/format.js";
import { PagePanel } from "../ui/panel.js";
import { t } from "../ui/texts.js";
import { costOf, figure, inWords, secondsOf } from "./runs-model.js";

/** @import { ExperimentRuns } from "./runs-model.js" */
/** @import { ExperimentEntry as Experiment } from "../net/rest.js" */

const MOST_RUNS = 10_000;
const SKELETONS = 4; // rows without words, until the experiments were read

const HEADS = [
  t("experiment-list.experiment"),
  t("experiment-list.time"),
  t("experiment-list.the_chapter"),
  t("experiment-list.last_run"),
];

/** @extends {PagePanel<ExperimentRuns>} */
class ExperimentList extends PagePanel {
  #list = make("tbody");
  #status = make("p.note", { role: "status" }, t("experiment-list.reading_what_experiments_there_are"));
  #short = make("button.button.primary", { hidden: true, onclick: () => void this.model.beginShort() });
  /** @type {Map<string, {button: HTMLButtonElement, last: HTMLElement}>} */
  #starts = new Map();

  /** @override */
  build() {
    const table = make(
      "table.experiments",
      make("caption.visually-hidden", t("experiment-list.shortest_first")),
      make("thead", make("tr", ...HEADS.map((head) => make("th", { scope: "col" }, head)), make("td"))),
      this.#list,
    );
    const head = make("div.row.experiment-head", this.#status, this.#short);
    this.append(make("section.card.experiment-table", head, table));
    this.#list.replaceChildren(...Array.from({ length: SKELETONS }, skeleton));
  }

  /** @override */
  draw() {
    const runs = this.model;
    const { experiments, trouble, may, running } = runs;
    if (experiments && this.#starts.size !== experiments.length) {
      this.#starts.clear();
      this.#list.replaceChildren(...experiments.map((one) => this.#row(one)));
    }
    const why = !may && experiments ? t("experiment-list.you_are_watching_only_an_operator") : "";
    write(
      this.#status,
      experiments
        ? why || (running ? t("experiment-list.title_runs_one_at_a_time", { title: running.title }) : trouble)
        : trouble,
    );
    if (!experiments && !trouble) write(this.#status, t("experiment-list.reading_what_experiments_there_are"));
    const seconds = runs.short.reduce((sum, one) => sum + secondsOf(one), 0);
    const left = t("experiment-list.left_to_run", { count: runs.queue.length });
    const offer = t("experiment-list.run_all_short_ones", { inwords: inWords(seconds) });
    write(this.#short, runs.queue.length ? left : offer);
    this.#short.hidden = seconds === 0;
    this.#short.disabled = !may || running !== null || runs.queue.length > 0;
    for (const [name, { button, last }] of this.#starts) {
      button.disabled = !may || running !== null;
      last.replaceChildren(...lastOf(runs.runs?.find(({ experiment }) => experiment === name)));
    }
  }

  /** @param {Experiment} one */
  #row(one) {
    const whole = { step: 1, required: true };
    const count = numberField(one.counts, { ...whole, value: one.runs, min: 1, max: MOST_RUNS });
    const seed = numberField(t("experiment-list.seed"), { ...whole, value: 0, min: 0, max: 10 ** 9 });
    const cost = make("td.experiment-time");
    const last = make("td.experiment-last");
    const [printed] = one.chapter;
    const chapter = make("td", printed ? figure(printed.value, printed.unit) : "–", note(printed?.name));
    const form = make("form.row.experiment-form", { id: `run-${one.name}` });
    const button = make(
      "button.button",
      { type: "submit", form: form.id, "aria-label": t("experiment-list.run_title", { title: one.title }) },
      icon("play"),
      t("experiment-list.run"),
    );
    form.append(make("label.inline", one.counts, count), make("label.inline", t("experiment-list.seed"), seed));
    const price = () =>
      write(
        cost,
        count.checkValidity()
          ? costOf(one, count.valueAsNumber)
          : t("experiment-list.1_to_mostruns", { mostruns: MOST_RUNS }),
      );
    count.addEventListener("input", price);
    price();
    onSubmit(
      form,
      () => void this.#begin({ experiment: one.name, runs: count.valueAsNumber, seed: seed.valueAsNumber }),
    );
    const about = make(
      "details.experiment-about",
      make("summary", t("experiment-list.details")),
      one.reproduces && make("p", one.reproduces),
      form,
      make("p", t("experiment-list.on_the_command_line"), make("code", `beckon experiment ${one.name}`)),
    );
    form.addEventListener("invalid", () => (about.open = true), true); // the browser points at the number
    const row = make("tr", make("th", { scope: "row" }, one.title, about), cost, chapter, last, make("td", button));
    mark(row, "data-experiment", one.name);
    for (const [n, cell] of [cost, chapter, last].entries()) mark(cell, "data-head", HEADS[n + 1] ?? "");
    this.#starts.set(one.name, { button, last });
    return row;
  }

  /** On a narrow page the run goes on below the list. @param {object} request */
  async #begin(request) {
    await this.model.begin(request);
    document.querySelector("experiment-result .page-card")?.scrollIntoView({ block: "nearest" });
  }
}

/** The newest run of an experiment. @param {import("../net/rest.js").ExperimentRunState | undefined} run */
function lastOf(run) {
  if (!run) return ["–"];
  const first = run.compared.find(({ ours }) => ours !== null);
  const result = first ? figure(first.ours, first.unit) : run.reason || t(`state.${run.state}`);
  return [result, note(date(run.at_s))];
}

/** @param {string} [words] */
const note = (words = "") => make("span.note", words);

const skeleton = () =>
  make("tr.experiment-skeleton", { "aria-hidden": "true" }, make("td", { colspan: "5" }, make("span"), make("span")));

customElements.define("experiment-list", ExperimentList);
