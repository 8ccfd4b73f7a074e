// Element <experiment-result>: progress of a run, then its figures beside the chapter's, its table and its files.

import { icon, make, mark, write } from "../ui/element.js";
import { timeOfDay } from "../ui/format.js";
import { Panel } from "../ui/panel.js";
import { figure, fileOf, inWords } from "./runs-model.js";

/** @typedef {import("./runs-model.js").ExperimentRuns} ExperimentRuns */
/** @typedef {import("./runs-model.js").ExperimentRun} ExperimentRun */

const NOTHING =
  "Run one: its progress appears here, then its figures beside the chapter's, and the files that the command line writes. Runs are kept.";

class ExperimentResult extends Panel {
  /** @type {ExperimentRuns | null} */
  #runs = null;
  #title = make("h2", {}, "Nothing was run yet");
  #about = make("p", { class: "note" }, NOTHING);
  #doing = make("p", { class: "experiment-doing" });
  #bar = make("div", { class: "bar-fill" });
  #progress = make(
    "div",
    { class: "progress", role: "progressbar", "aria-label": "Progress", "aria-valuemin": "0", "aria-valuemax": "100" },
    this.#bar,
  );
  #cancel = make("button", { type: "button", class: "button" }, icon("close"), "Cancel");
  #going = make("div", { class: "experiment-going", hidden: true }, this.#doing, this.#progress, this.#cancel);
  #content = make("div", { class: "experiment-content" });
  #list = make("ul", { class: "experiment-runs" });
  #before = make(
    "section",
    { class: "card experiment-before", "aria-label": "Runs", hidden: true },
    make("div", { class: "card-head" }, make("h2", { class: "card-title" }, "Runs")),
    this.#list,
  );
  #drawn = "";
  #listed = "";

  /** @param {ExperimentRuns} runs */
  watch(runs) {
    this.#runs = runs;
    runs.onChange(() => this.#draw());
  }

  /** @override */
  build() {
    this.append(
      make(
        "section",
        { class: "card experiment-result", "aria-label": "Result" },
        this.#title,
        this.#about,
        this.#going,
        this.#content,
      ),
      this.#before,
    );
    this.#cancel.addEventListener("click", () => {
      const run = this.#runs?.selected;
      if (run) void this.#runs?.cancel(run.id);
    });
  }

  #draw() {
    const run = this.#runs?.selected ?? null;
    this.#drawList();
    if (run === null) {
      write(this.#title, "Nothing was run yet");
      write(this.#about, NOTHING);
      this.#going.hidden = true;
      this.#content.replaceChildren();
      this.#drawn = "";
      return;
    }
    const running = run.state === "running";
    write(this.#title, run.title);
    write(
      this.#about,
      `${run.runs} runs, seed ${run.seed} · ${run.who}, ${timeOfDay(run.at_s)} · ${STATES[run.state]} ${inWords(run.took_s)}`,
    );
    this.#going.hidden = !running;
    write(this.#doing, run.doing);
    const percent = run.progress === null ? null : String(Math.round(100 * run.progress));
    this.#bar.style.width = `${percent ?? 100}%`;
    mark(this.#progress, "aria-valuenow", percent);
    mark(this.#progress, "data-uncounted", percent === null);
    this.#cancel.disabled = !this.#runs?.may;
    const key = running ? run.id : JSON.stringify([run.id, run.state, run.files.length]);
    if (key === this.#drawn) return;
    this.#drawn = key;
    this.#content.replaceChildren(...(running ? [] : result(run)));
  }

  #drawList() {
    const runs = this.#runs?.runs ?? [];
    this.#before.hidden = runs.length === 0;
    const shown = this.#runs?.selected?.id;
    const key = JSON.stringify([runs.map(({ id, state }) => [id, state]), shown, this.#runs?.may]);
    if (key === this.#listed) return;
    this.#listed = key;
    this.#list.replaceChildren(...runs.map((run) => this.#row(run, run.id === shown)));
  }

  /** @param {ExperimentRun} run @param {boolean} shown */
  #row(run, shown) {
    const open = make(
      "button",
      { type: "button", class: "experiment-open", "aria-current": shown ? "true" : null },
      icon(run.state === "running" ? "running" : run.state),
      make(
        "span",
        {},
        make("span", { class: "experiment-name" }, run.title),
        make("span", { class: "note" }, `${run.runs} runs, seed ${run.seed} · ${run.who} · ${dayOf(run.at_s)}`),
      ),
    );
    open.addEventListener("click", () => this.#runs?.choose(run.id));
    const away = make(
      "button",
      {
        type: "button",
        class: "icon-button",
        "aria-label": `Delete: ${run.title}, ${dayOf(run.at_s)}`,
        title: "Delete",
      },
      icon("trash"),
    );
    away.addEventListener("click", () => void this.#runs?.remove(run.id));
    return make("li", {}, open, this.#runs?.may && run.state !== "running" && away);
  }
}

const STATES = { running: "running for", done: "done in", cancelled: "cancelled after", failed: "failed after" };

/** @param {number} seconds Unix time */
const dayOf = (seconds) => `${new Date(seconds * 1000).toLocaleDateString()} ${timeOfDay(seconds).slice(0, 5)}`;

/** @param {ExperimentRun} run */
function result(run) {
  const figures = run.files.filter((one) => one.figure);
  const parts = [
    run.reason && make("p", { class: "experiment-reason" }, icon("warning"), run.reason),
    run.compared.length > 0 && compared(run),
    figures.length > 0 &&
      make(
        "div",
        { class: "experiment-figures" },
        ...figures.map(({ name }) => {
          const says = name.replace(/\.\w+$/, "").replace(/_/g, " ");
          const shown = make("img", { src: fileOf(run.id, name), alt: `${run.title}: ${says}`, loading: "lazy" });
          const link = make("a", { href: fileOf(run.id, name), target: "_blank", rel: "noopener" }, shown);
          return make("figure", {}, link, make("figcaption", { class: "note" }, says));
        }),
      ),
    run.text &&
      make("pre", { class: "experiment-text", tabindex: "0", role: "group", "aria-label": "Result as text" }, run.text),
    run.files.length > 0 && files(run),
  ];
  return parts.filter((part) => part instanceof Node);
}

/** @param {ExperimentRun} run */
function compared({ compared: rows }) {
  const heads = ["Figure", "The chapter", "Here"].map((name) => make("th", { scope: "col" }, name));
  const body = rows.map(({ name, unit, chapter, ours }) =>
    make(
      "tr",
      {},
      make("th", { scope: "row" }, name),
      make("td", {}, figure(chapter, unit)),
      make("td", {}, figure(ours, unit)),
    ),
  );
  return make(
    "div",
    { class: "experiment-scroll", tabindex: "0", role: "group", "aria-label": "Beside the chapter's figures" },
    make("table", {}, make("thead", {}, make("tr", {}, ...heads)), make("tbody", {}, ...body)),
  );
}

/** @param {ExperimentRun} run */
const files = (run) =>
  make(
    "ul",
    { class: "experiment-files", "aria-label": "Files" },
    ...run.files.map(({ name, bytes }) =>
      make(
        "li",
        {},
        make("a", { class: "link", href: fileOf(run.id, name), download: name }, icon("download"), name),
        make(
          "span",
          { class: "note" },
          ` ${bytes < 1e6 ? `${Math.ceil(bytes / 1000)} kB` : `${(bytes / 1e6).toFixed(1)} MB`}`,
        ),
      ),
    ),
  );

customElements.define("experiment-result", ExperimentResult);
