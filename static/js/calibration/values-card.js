// Element <values-card>: estimated values and standard deviations (Table 3), next to the active ones.

import { isNew, make, mark, write } from "../ui/element.js";
import { t } from "../ui/texts.js";
import { cameraRows, mountRows } from "./figures.js";

/** @import { Calibration } from "./types.js" */

export class ValuesCard extends HTMLElement {
  #title = make("h2.card-title");
  #head = make("tr");
  #body = make("tbody");
  #note = make("p.note");

  connectedCallback() {
    if (this.children.length) return;
    this.classList.add("card");
    this.append(
      make("div.card-head", this.#title),
      make("table.values", make("thead", this.#head), this.#body),
      this.#note,
    );
  }

  /** @param {Calibration} calibration */
  show({ kind, solution, active_compare: compare }) {
    this.hidden = solution === null;
    if (!solution || !isNew(this, solution?.["sd"], solution?.["fx"], solution?.["translation_m"], compare)) return;
    const rows = kind === "camera" ? cameraRows(solution, compare) : mountRows(solution, compare);
    const compared = rows.some((row) => row.other);
    write(this.#title, kind === "camera" ? t("values-card.the_camera") : t("values-card.the_camera_on_the_laser"));
    this.classList.toggle("is-compared", compared); // no room for explanations then
    const columns = [
      "",
      t("values-card.value"),
      t("values-card.standard_dev"),
      ...(compared ? [t("values-card.in_use"), t("values-card.change")] : []),
    ];
    this.#head.replaceChildren(...columns.map((name) => make("th", { scope: "col" }, name)));
    this.#body.replaceChildren(
      ...rows.map((row) => {
        const name = make(
          "th",
          { scope: "row", title: row.says },
          make("span.value-name", row.name),
          make("span.note", row.says),
        );
        const change = make("td", row.change);
        mark(change, "data-far", row.far);
        const open = row.value === "not known" && "open";
        const cells = [make("td", { class: open }, row.value), make("td", row.sd)];
        return make("tr", name, ...cells, ...(compared ? [make("td", row.other), change] : []));
      }),
    );
    write(
      this.#note,
      kind === "camera"
        ? t("values-card.one_standard_deviation_the_paper_s", { equation44: equation44(solution) })
        : t("values-card.one_standard_deviation_turns_are_away"),
    );
  }
}

/**
 * The coefficients in the printed form of eq. 44, where the console runs the chapter's own forms.
 * @param {Record<string, any>} solution
 */
function equation44(solution) {
  const printed = solution["eq_44"];
  if (!printed) return "";
  const names = /** @type {const} */ ([
    ["k1", "k₁"],
    ["k2", "k₂"],
    ["p1", "p₁"],
    ["p2", "p₂"],
  ]);
  const values = names.map(([key, name]) => `${name} = ${printed[key].toExponential(3)}`).join(", ");
  return ` As printed (eq. 44, f = ${printed["f_px"].toFixed(2)} px): ${values}.`;
}

customElements.define("values-card", ValuesCard);
