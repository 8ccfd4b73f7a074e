// Element <findings-card>: findings about a solution in sentences: predicted error, warnings, checks.

import { cardHead, icon, isNew, make, write } from "../ui/element.js";
import { fixed } from "../ui/format.js";
import { t } from "../ui/texts.js";

/** @import { Calibration } from "./types.js" */

export class FindingsCard extends HTMLElement {
  #offsets = make("tbody");
  #table = make(
    "table.values.laser-offset-table",
    make("caption", t("findings-card.where_a_laser_point_lands_in")),
    make(
      "thead",
      make(
        "tr",
        ...[t("findings-card.distance"), t("findings-card.sideways"), t("findings-card.up_down")].map((name) =>
          make("th", { scope: "col" }, name),
        ),
      ),
    ),
    this.#offsets,
  );
  #list = make("ul.findings");

  connectedCallback() {
    if (this.children.length) return;
    this.classList.add("card");
    this.append(cardHead(t("findings-card.what_to_know")), this.#table, this.#list);
  }

  /** @param {Calibration} calibration */
  show({ solution, check, kind }) {
    const findings = solution ? sentences(kind, solution, check?.words ?? "") : [];
    this.hidden = findings.length === 0 && !solution?.["laser_offset"];
    if (!isNew(this, findings, solution?.["laser_offset"])) return;
    /** @type {Array<{distance_m: number, sideways_px: number, up_down_px: number}>} */
    const offsets = solution?.["laser_offset"] ?? [];
    this.#table.hidden = offsets.length === 0;
    this.#offsets.replaceChildren(
      ...offsets.map((row) =>
        make(
          "tr",
          make("th", { scope: "row" }, `${fixed(row.distance_m, 1)} m`),
          make("td", t("findings-card.fixed_px", { fixed: fixed(row.sideways_px, 1) })),
          make("td", t("findings-card.fixed_px", { fixed: fixed(row.up_down_px, 1) })),
        ),
      ),
    );
    this.#list.replaceChildren(
      ...findings.map(({ doubt, words }) => {
        const sentence = make("span");
        write(sentence, words);
        return make("li", { "data-doubt": doubt }, icon(doubt ? "warning" : "done"), sentence);
      }),
    );
  }
}

/**
 * @param {"camera" | "laser"} kind
 * @param {Record<string, any>} solution
 * @param {string} check how a pose without a part in the solution was predicted
 * @returns {Array<{doubt: boolean, words: string}>}
 */
function sentences(kind, solution, check) {
  /** @type {string[]} */
  const doubts = [...(solution["weak_directions"] ?? []), ...(solution["warnings"] ?? [])];
  /** @type {string[]} */
  const good = [];
  if (kind === "camera")
    good.push(
      t("findings-card.corners_are_met_to_fixed_px", {
        fixed: fixed(solution["rms_px"], 2),
        solution: solution["views_used"],
      }),
    );
  else
    good.push(
      t("findings-card.board_and_laser_agree_to_fixed", {
        fixed: fixed(1e3 * solution["residual_rms_m"], 1),
        solution: solution["poses_used"],
      }),
    );
  if (kind === "laser" && solution["square_words"]) good.push(`${solution["square_words"]}.`);
  if (check) good.push(check);
  return [...doubts.map((words) => ({ doubt: true, words })), ...good.map((words) => ({ doubt: false, words }))];
}

customElements.define("findings-card", FindingsCard);
