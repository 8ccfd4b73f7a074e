// Client model of the experiments page: what there is, all runs, the selected one, and requests to the server.

import { address } from "../net/api.js";
import { fixed } from "../ui/format.js";
import { RunsModel } from "../ui/page-model.js";
import { inLanguage, t, translate } from "../ui/texts.js";

/** @import { ExperimentEntry as Experiment, ExperimentRunState as ExperimentRun } from "../net/rest.js" */
/** @import { Session } from "../net/session.js" */

const ROOT = "api/experiments";
const ASK_MS = 1000;
const SHORT_S = 90; // of processor time, up to which an experiment is called short
/** @type {Readonly<Record<string, string>>} */
const SUBSCRIPTS = { u: "ᵤ", v: "ᵥ", 0: "₀" };

/** @param {string} id @param {string} name of a file */
export const fileOf = (id, name) =>
  address(`${ROOT}/runs/${encodeURIComponent(id)}/files/${encodeURIComponent(name)}`).href;

/** @extends {RunsModel<ExperimentRun>} */
export class ExperimentRuns extends RunsModel {
  /** @type {Experiment[] | null} null until they were read */
  experiments = null;
  /** @type {string[]} names of those that are run one after the other */
  queue = [];

  /** @param {Session} session */
  constructor(session) {
    super(session, ROOT, `${ROOT}/runs`);
    this.poll(ASK_MS, () => this.shown && (!this.experiments || this.running !== null || this.queue.length > 0));
  }

  /** @override @param {{experiments: Experiment[] | null, runs: ExperimentRun[]}} answer `experiments`: null until they were read */
  take({ experiments, runs }) {
    for (const one of experiments ?? []) {
      for (const name of /** @type {const} */ (["title", "reproduces", "counts"])) translate(one, name);
      one.chapter.forEach(writeName);
    }
    for (const run of runs) {
      translate(run, "title");
      translate(run, "reason");
      run.compared.forEach(writeName);
    }
    [this.experiments, this.runs] = [shortestFirst(experiments), runs];
    const [next] = this.queue;
    const one = next && !this.running && experiments?.find(({ name }) => name === next);
    if (!one) return;
    this.queue.shift();
    void this.begin({ experiment: one.name, runs: one.runs, seed: 0 });
  }

  /** @override @param {ExperimentRun} run */
  endOf({ title, state, reason }) {
    return `${title}: ${t(`state.${state}`)}. ${reason}`;
  }

  /** @returns {Experiment[]} */
  get short() {
    return (this.experiments ?? []).filter((one) => secondsOf(one) <= SHORT_S);
  }

  /** What a run consists of: "240 utterances". @param {ExperimentRun} run */
  count({ experiment, runs }) {
    return `${runs} ${this.experiments?.find(({ name }) => name === experiment)?.counts ?? ""}`.trim();
  }

  beginShort() {
    this.queue = this.short.map(({ name }) => name);
    return this.read();
  }

  /** @override @param {string} id */
  cancel(id) {
    this.queue = [];
    return super.cancel(id);
  }
}

/**
 * Every figure that the chapter prints, by experiment, with that of its newest run; null where there is none.
 * @param {readonly Experiment[]} experiments
 * @param {readonly ExperimentRun[]} runs newest first
 */
export const besideChapter = (experiments, runs) =>
  experiments
    .filter(({ chapter }) => chapter.length > 0)
    .map(({ name: experiment, title, chapter }) => {
      const run = runs.find((one) => one.experiment === experiment && one.compared.some(({ ours }) => ours !== null));
      const rows = chapter.map(({ name, unit, value }) => {
        const ours = run?.compared.find((one) => one.name === name)?.ours ?? null;
        return { name, unit, chapter: value, ours };
      });
      return { title, rows };
    });

/** A duration in words: "40 s", "about 3 min", "about 2 h". @param {number} seconds */
export function inWords(seconds) {
  if (seconds < 90) return `${Math.max(1, Math.round(seconds))} s`;
  if (seconds < 5400) return `${Math.round(seconds / 60)} min`;
  return `${(seconds / 3600).toFixed(1)} h`;
}

/** What a run does: "12 of 40 runs, 1.3 a second, 22 s to go", in the page's language. @param {string} doing */
export function doingOf(doing) {
  if (doing === "Starting…") return t("status.starting");
  const [, done, all, left] = /^(\d+) of (\d+) runs, .*, (.+) to go$/.exec(doing) ?? [];
  if (!done) return inLanguage(doing);
  return t(done === all ? "runs-model.done_of_all" : "runs-model.done_of_all_left_to_go", { done, all, left });
}

/** Processor time as it is offered [s]; Infinity where it is not known. @param {Experiment} experiment */
export const secondsOf = ({ base_s, run_s, runs }) => base_s + run_s * runs || Infinity;

/** What takes least stands first; what is not known, last. @param {Experiment[] | null} experiments */
export const shortestFirst = (experiments) =>
  experiments?.toSorted((one, other) => secondsOf(one) - secondsOf(other) || 0) ?? null;

/**
 * Processor time of so many runs, in words; "" when it is not known.
 * @param {Experiment} experiment
 * @param {number} runs
 */
export function costOf({ base_s, run_s }, runs) {
  const seconds = base_s + run_s * runs;
  return seconds > 0 ? t("runs-model.about_inwords_of_one_processor", { inwords: inWords(seconds) }) : "";
}

/** A name with its symbols as the chapter prints them, f_u → fᵤ, and no number apart from its unit. @param {string} name */
export const inSymbols = (name) =>
  name
    .replace(/(?<=\b[a-z])_([uv0])\b/g, (_, below) => SUBSCRIPTS[below] ?? below)
    .replace(/(?<=\d) (?=(?:m|cm|px|dB)\b)/g, "\u00a0");

/** Write what a figure is of in the page's language, its symbols as the chapter prints them. @param {{name: string}} figure */
function writeName(figure) {
  translate(figure, "name");
  figure.name = inSymbols(figure.name);
}

/** A figure with as many digits as it deserves. @param {number | null} value @param {string} unit */
export function figure(value, unit) {
  if (value === null) return "–";
  const digits = Math.abs(value) >= 100 ? 1 : Math.abs(value) >= 1 ? 2 : 3;
  return `${fixed(value, digits)}${unit && ` ${unit}`}`;
}
