// Element <experiment-result>: progress of a run, then its figures beside the chapter's, its table and its files.
// Element <experiment-runs>: every run of an experiment, newest first.
// Element <experiment-figures>: every figure that the chapter prints, beside that of the newest run.

import { address, wordedPath } from "../net/api.js";
import { icon, isNew, make, write } from "../ui/element.js";
import { day, timeOfDay } from "../ui/format.js";
import { PagePanel } from "../ui/panel.js";
import { RunList, RunProgress } from "../ui/run-parts.js";
import { t } from "../ui/texts.js";
import { besideChapter, doingOf, figure, fileOf, inWords } from "./runs-model.js";

/** @import { ExperimentRunState as ExperimentRun } from "../net/rest.js" */
/** @import { ExperimentRuns } from "./runs-model.js" */

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

const NOTHING = t("experiment-result.run_one_its_progress_appears_here");

/** @extends {PagePanel<ExperimentRuns>} */
class ExperimentResult extends PagePanel {
  #title = make("h2", t("experiment-result.nothing_was_run_yet"));
  #about = make("p.note", NOTHING);
  #going = new RunProgress(() => this.model);
  #content = make("div.stack");
  /** @override */
  build() {
    this.append(
      make(
        "section.card.page-card",
        { "aria-label": t("experiment-result.result") },
        this.#title,
        this.#about,
        this.#going.element,
        this.#content,
      ),
      make(/** @type {"div"} */ ("experiment-runs")),
    );
  }

  /** @override */
  draw() {
    const run = this.model.selected;
    const running = run?.state === "running";
    this.#going.show(run, this.model.may, running ? doingOf(run.doing) : "");
    if (run === null) {
      write(this.#title, t("experiment-result.nothing_was_run_yet"));
      write(this.#about, NOTHING);
      if (isNew(this.#content)) this.#content.replaceChildren();
      return;
    }
    write(this.#title, run.title);
    write(
      this.#about,
      t("experiment-result.runs_runs_seed_seed_who_timeofday", {
        runs: this.model.count(run),
        seed: run.seed,
        who: run.who,
        timeofday: timeOfDay(run.at_s),
        states: STATES[run.state],
        inwords: inWords(run.took_s),
      }),
    );
    if (isNew(this.#content, run.id, run.state, run.files.length)) {
      this.#content.replaceChildren(...(running ? [] : result(run)));
    }
  }
}

const STATES = {
  running: t("experiment-result.running_for"),
  done: t("experiment-result.done_in"),
  cancelled: t("experiment-result.cancelled_after"),
  failed: t("experiment-result.failed_after"),
};

/** @param {ExperimentRun} run */
function result(run) {
  const figures = run.files.filter((one) => one.figure);
  const parts = [
    run.reason && make("p.experiment-reason", icon("warning"), run.reason),
    run.compared.length > 0 && compared([{ title: "", rows: run.compared }]),
    figures.length > 0 &&
      make(
        "div.stack.experiment-figures",
        ...figures.map(({ name }) => {
          const says = name.replace(/\.\w+$/, "").replace(/_/g, " ");
          const shown = make("img", { src: fileOf(run.id, name), alt: `${run.title}: ${says}`, loading: "lazy" });
          const link = make("a", { href: fileOf(run.id, name), target: "_blank", rel: "noopener" }, shown);
          return make(
            "figure",
            link,
            make("figcaption.note", says, make("span.experiment-swipe", t("experiment-result.swipe_it"))),
          );
        }),
      ),
    run.text &&
      make(
        "pre.experiment-text",
        { tabindex: "0", role: "group", "aria-label": t("experiment-result.result_as_text") },
        run.text,
      ),
    run.files.length > 0 && files(run),
    make(
      "a.button",
      { href: address(wordedPath(`api/reports/experiments/${run.id}`)).href, download: "" },
      icon("print"),
      t("experiment-result.make_a_report"),
    ),
  ];
  return parts.filter((part) => part instanceof Node);
}

/** @param {ReturnType<typeof besideChapter>} groups each with a title where there are several */
function compared(groups) {
  const [printed, here] = [t("experiment-result.the_chapter"), t("experiment-result.here")];
  const heads = [t("experiment-result.figure"), printed, here].map((name) => make("th", { scope: "col" }, name));
  const body = groups.flatMap(({ title, rows }) => [
    ...(title ? [make("tr", make("th.experiment-group", { colspan: "3", scope: "rowgroup" }, title))] : []),
    ...rows.map(({ name, unit, chapter, ours }) =>
      make(
        "tr",
        make("th", { scope: "row" }, name),
        make("td", { "data-head": printed }, figure(chapter, unit)),
        make("td", { "data-head": here }, figure(ours, unit)),
      ),
    ),
  ]);
  return make(
    "div.experiment-scroll",
    { tabindex: "0", role: "group", "aria-label": t("experiment-result.beside_the_chapter_s_figures") },
    make("table", make("thead", make("tr", ...heads)), make("tbody", ...body)),
  );
}

/** @param {ExperimentRun} run */
const files = (run) =>
  make(
    "ul.experiment-files",
    { "aria-label": t("experiment-result.files") },
    ...run.files.map(({ name, bytes }) =>
      make(
        "li",
        make("a.link", { href: fileOf(run.id, name), download: name }, icon("download"), name),
        make("span.note", ` ${bytes < 1e6 ? `${Math.ceil(bytes / 1000)} kB` : `${(bytes / 1e6).toFixed(1)} MB`}`),
      ),
    ),
  );

customElements.define("experiment-result", ExperimentResult);

/** @extends {PagePanel<ExperimentRuns>} */
class ExperimentFigures extends PagePanel {
  #table = make("div");

  /** @override */
  build() {
    const title = t("experiment-result.the_chapter_s_figures");
    this.hidden = true;
    this.append(make("section.card.page-card", { "aria-label": title }, make("h2", title), this.#table));
  }

  /** @override */
  draw() {
    const groups = besideChapter(this.model.experiments ?? [], this.model.runs ?? []);
    this.hidden = groups.length === 0;
    if (groups.length && isNew(this.#table, groups)) this.#table.replaceChildren(compared(groups));
  }
}

customElements.define("experiment-figures", ExperimentFigures);
