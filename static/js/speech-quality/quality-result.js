// Element <quality-result>: progress and results of one measurement, one row per place.
// Element <quality-list>: stored measurements, newest first.

import { since } from "../calibration/active-calibration.js";
import { isNew, make, write } from "../ui/element.js";
import { fixed, timeOfDay } from "../ui/format.js";
import { meter } from "../ui/meter.js";
import { PagePanel } from "../ui/panel.js";
import { RunList, RunProgress } from "../ui/run-parts.js";
import { inLanguage, t } from "../ui/texts.js";
import { report } from "./runs.js";

/** @import { QualityRow as Row, QualityRunState as Run } from "../net/rest.js" */
/** @import { Place, Runs } from "./runs.js" */

const HEADS = [
  t("quality-result.distance"),
  t("quality-result.voice_over_noise"),
  t("quality-result.commands_whole"),
  t("quality-result.wrong_words"),
  "OSQE D",
  "OSQE R",
  "STOI",
  t("quality-result.report"),
];

const PROMISE = t("quality-result.for_every_place_you_will_see") + t("quality-result.the_robot_how_alike_the_two");

/** @extends {PagePanel<Runs>} */
class QualityResult extends PagePanel {
  #title = make("h2", "");
  #summary = make("p");
  #verdict = make("p.note");
  #going = new RunProgress(() => this.model);
  #body = make("tbody");
  #table = make(
    "div.quality-scroll",
    { tabindex: "0", role: "group", "aria-label": t("quality-result.figures") },
    make("table", make("thead", make("tr", ...HEADS.map((name) => make("th", { scope: "col" }, name)))), this.#body),
  );

  /** @override */
  build() {
    this.append(
      make(
        "section.card.page-card.quality-result",
        { "aria-label": t("quality-result.result") },
        this.#title,
        this.#summary,
        this.#going.element,
        this.#table,
        this.#verdict,
        make("p.note", t("quality-result.osqe_d_and_r_compare_wrong")),
      ),
    );
    this.draw();
  }

  /** @override */
  draw() {
    const run = this.model.selected;
    if (run === null) {
      write(this.#title, t("quality-result.nothing_was_measured_here_yet"));
      write(this.#summary, PROMISE);
      this.#verdict.hidden = true;
      this.#going.show(null, false, "");
      const { planned } = this.model;
      this.#table.hidden = planned.length === 0;
      if (isNew(this, planned)) this.#body.replaceChildren(...planned.map(plannedLine));
      return;
    }
    const running = run.state === "running";
    write(
      this.#title,
      running
        ? t("quality-result.measuring")
        : t("quality-result.measured_timeofday", { timeofday: timeOfDay(run.at_s) }),
    );
    write(this.#summary, inLanguage(run.state === "failed" ? run.reason : run.summary));
    this.#going.show(run, this.model.may, running || run.state === "cancelled" ? inLanguage(run.doing) : "");
    this.#table.hidden = run.rows.length === 0;
    const [judged] = run.rows.filter((row) => row.verdict);
    write(this.#verdict, judged ? `${place(judged)}: ${inLanguage(judged.verdict ?? "")}` : "");
    this.#verdict.hidden = !judged;
    if (!isNew(this, run.id, run.rows, run.reports, running)) return;
    this.#body.replaceChildren(...run.rows.map((row, index) => line(run, row, index)));
  }
}

/** @param {Row} row */
const place = ({ distance_m, snr_db }) =>
  t("quality-result.at_distancem_m_and_signed_db", { distancem: distance_m, signed: signed(snr_db) });

/** @param {number} value */
const signed = (value) => fixed(value, Number.isInteger(value) ? 0 : 1);

/** @param {Place} place @returns {HTMLElement[]} */
const headOf = ({ distance_m, snr_db }) => [
  make("th", { scope: "row" }, `${distance_m} m`),
  make("td", t("quality-result.signed_db", { signed: signed(snr_db) })),
];

/** @param {Place} place that would be measured */
const plannedLine = (place) => make("tr.is-empty", ...headOf(place), ...HEADS.slice(2).map(() => make("td", "–")));

/** @param {Run} run @param {Row} row @param {number} index */
function line(run, row, index) {
  const head = headOf(row);
  if (row.commands === undefined) {
    const why = inLanguage(row.refused) || (run.state === "running" ? "…" : t("quality-result.not_measured"));
    return make("tr.is-empty", ...head, make("td", { colspan: "6" }, why));
  }
  const ratio = row.osqe_r === null || row.osqe_r === undefined ? "–" : row.osqe_r.toFixed(2);
  const difference = row.osqe_d ?? 0;
  const share = meter("div.meter.share", { "aria-hidden": "true" });
  share.set((row.commands_exact ?? 0) / row.commands);
  return make(
    "tr",
    ...head,
    make(
      "td",
      share.element,
      t("quality-result.commandsexact_of_commands", { commandsexact: row.commands_exact, commands: row.commands }),
    ),
    make(
      "td",
      t("quality-result.erroneouswordsrobot_of_words_mouth_erroneouswordsperson", {
        erroneouswordsrobot: row.erroneous_words_robot,
        words: row.words,
        erroneouswordsperson: row.erroneous_words_person,
      }),
    ),
    make("td", difference > 0 ? `+${difference}` : signed(difference)),
    make("td", { title: inLanguage(row.reason ?? "") }, ratio),
    make("td", (row.stoi ?? 0).toFixed(2)),
    make(
      "td",
      run.reports[index] &&
        make("a.link", { href: report(run.id, index), target: "_blank", rel: "noopener" }, t("quality-result.open")),
    ),
  );
}

customElements.define("quality-result", QualityResult);

/** @extends {RunList<import("./runs.js").Runs>} */
class QualityList extends RunList {
  /** @override */
  heading = t("quality-list.measured_before");

  /** @override @param {import("../net/rest.js").QualityRunState} run */
  words({ setup, who, at_s, summary, reason, doing, state }) {
    const about = { join: setup.distances_m.join(", "), phrases: setup.phrases, who, since: since(at_s) };
    return {
      name: inLanguage(summary || reason || doing) || t(`state.${state}`),
      note: t("quality-list.join_m_phrases_phrases_who_since", about),
      away: t("quality-list.delete_this_measurement"),
    };
  }
}

customElements.define("quality-list", QualityList);
