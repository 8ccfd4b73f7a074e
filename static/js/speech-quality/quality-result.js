// Element <quality-result>: progress and results of one measurement, one row per place.

import { icon, make, mark, write } from "../ui/element.js";
import { timeOfDay } from "../ui/format.js";
import { Panel } from "../ui/panel.js";
import { report } from "./runs.js";

/** @typedef {import("./runs.js").Runs} Runs */
/** @typedef {import("./runs.js").Row} Row */
/** @typedef {import("./runs.js").Run} Run */

const HEADS = ["Distance", "Voice over noise", "Commands whole", "Wrong words", "OSQE D", "OSQE R", "STOI", "Report"];

const PROMISE =
  "For every place you will see how many commands come through whole, how many words go wrong at the mouth and at " +
  "the robot, how alike the two sounds are, and a report with both texts side by side, the wrong words marked.";

class QualityResult extends Panel {
  /** @type {Runs | null} */
  #runs = null;
  #title = make("h2", {}, "");
  #summary = make("p", { class: "quality-summary" });
  #verdict = make("p", { class: "note" });
  #doing = make("span", { class: "quality-doing" });
  #bar = make("div", { class: "bar-fill" });
  #progress = make(
    "div",
    { class: "progress", role: "progressbar", "aria-label": "Progress", "aria-valuemin": "0", "aria-valuemax": "100" },
    this.#bar,
  );
  #cancel = make("button", { type: "button", class: "button" }, icon("close"), "Cancel");
  #going = make("div", { class: "quality-going" }, this.#doing, this.#progress, this.#cancel);
  #body = make("tbody");
  #table = make(
    "div",
    { class: "quality-scroll", tabindex: "0", role: "group", "aria-label": "Figures" },
    make(
      "table",
      {},
      make("thead", {}, make("tr", {}, ...HEADS.map((name) => make("th", { scope: "col" }, name)))),
      this.#body,
    ),
  );
  #drawn = "";

  /** @param {Runs} runs */
  watch(runs) {
    this.#runs = runs;
    runs.onChange(() => this.#draw());
  }

  /** @override */
  build() {
    this.append(
      make(
        "section",
        { class: "card quality-result", "aria-label": "Result" },
        this.#title,
        this.#summary,
        this.#going,
        this.#table,
        this.#verdict,
        make(
          "p",
          { class: "note" },
          "OSQE D and R compare wrong words at the mouth with wrong words at the robot (eq. 41, 42): below zero, or below one, the robot hears worse.",
        ),
      ),
    );
    this.#cancel.addEventListener("click", () => {
      const run = this.#runs?.shown;
      if (run) void this.#runs?.cancel(run.id);
    });
    this.#draw();
  }

  #draw() {
    const run = this.#runs?.shown ?? null;
    if (run === null) {
      write(this.#title, "Nothing was measured here yet");
      write(this.#summary, PROMISE);
      for (const part of [this.#going, this.#table, this.#verdict]) part.hidden = true;
      return;
    }
    const running = run.state === "running";
    write(this.#title, running ? "Measuring" : `Measured ${timeOfDay(run.at_s)}`);
    write(this.#summary, run.state === "failed" ? run.reason : run.summary);
    this.#going.hidden = !running && run.state !== "cancelled";
    this.#cancel.hidden = this.#progress.hidden = !running;
    this.#cancel.disabled = !this.#runs?.may;
    write(this.#doing, run.doing);
    const percent = Math.round(100 * run.progress);
    this.#bar.style.width = `${percent}%`;
    mark(this.#progress, "aria-valuenow", String(percent));
    this.#table.hidden = run.rows.length === 0;
    const [judged] = run.rows.filter((row) => row.verdict);
    write(this.#verdict, judged ? `${place(judged)}: ${judged.verdict}` : "");
    this.#verdict.hidden = !judged;
    const key = JSON.stringify([run.id, run.rows, run.reports, running]);
    if (key === this.#drawn) return;
    this.#drawn = key;
    this.#body.replaceChildren(...run.rows.map((row, index) => line(run, row, index)));
  }
}

/** @param {Row} row */
const place = ({ distance_m, snr_db }) => `At ${distance_m} m and ${signed(snr_db)} dB`;

/** @param {number} value */
const signed = (value) => String(value).replace("-", "−");

/**
 * @param {Run} run
 * @param {Row} row
 * @param {number} index
 */
function line(run, row, index) {
  const head = [make("th", { scope: "row" }, `${row.distance_m} m`), make("td", {}, `${signed(row.snr_db)} dB`)];
  if (row.commands === undefined) {
    const why = row.refused || (run.state === "running" ? "…" : "not measured");
    return make("tr", { class: "is-empty" }, ...head, make("td", { colspan: "6" }, why));
  }
  const ratio = row.osqe_r === null || row.osqe_r === undefined ? "–" : row.osqe_r.toFixed(2);
  const difference = row.osqe_d ?? 0;
  return make(
    "tr",
    {},
    ...head,
    make("td", {}, bar((row.commands_exact ?? 0) / row.commands), ` ${row.commands_exact} of ${row.commands}`),
    make("td", {}, `${row.erroneous_words_robot} of ${row.words} (mouth: ${row.erroneous_words_person})`),
    make("td", {}, difference > 0 ? `+${difference}` : signed(difference)),
    make("td", { title: row.reason }, ratio),
    make("td", {}, (row.stoi ?? 0).toFixed(2)),
    make(
      "td",
      {},
      run.reports[index] &&
        make("a", { class: "link", href: report(run.id, index), target: "_blank", rel: "noopener" }, "Open"),
    ),
  );
}

/** @param {number} share 0..1 */
function bar(share) {
  const fill = make("span", { class: "share-fill" });
  fill.style.width = `${Math.round(100 * share)}%`;
  return make("span", { class: "share", "aria-hidden": "true" }, fill);
}

customElements.define("quality-result", QualityResult);
