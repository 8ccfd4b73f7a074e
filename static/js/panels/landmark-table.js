// Element <landmark-table>: landmarks with position, uncertainty, hits and misses (the paper’s table L).

import { make, write } from "../ui/element.js";
import { fixed, largestSigma } from "../ui/format.js";
import { t } from "../ui/texts.js";

/** @import { LandmarkRow } from "../net/messages.js" */

const EVERY_MS = 400;
const COLUMNS = ["#", "x m", "y m", "± cm", t("landmark-table.hits"), t("landmark-table.missed")];

export class LandmarkTable extends HTMLElement {
  #body = make("tbody");
  #empty = make("p.record-empty", t("landmark-table.no_landmark_yet_a_corner_counts"));
  #shownAt = -Infinity;

  connectedCallback() {
    if (this.children.length) return;
    this.tabIndex = 0; // so that Page Up and Page Down reach it
    this.setAttribute("role", "region");
    this.setAttribute("aria-label", t("landmark-table.landmarks"));
    const head = make("tr", ...COLUMNS.map((name) => make("th", { scope: "col" }, name)));
    this.append(
      make(
        "table.landmarks",
        make("caption.visually-hidden", t("landmark-table.landmarks")),
        make("thead", head),
        this.#body,
      ),
      this.#empty,
    );
  }

  /** @param {readonly LandmarkRow[]} landmarks */
  show(landmarks) {
    const now = performance.now();
    if (this.offsetParent === null || now - this.#shownAt < EVERY_MS) return;
    this.#shownAt = now;
    this.#empty.hidden = landmarks.length > 0;
    while (this.#body.rows.length > landmarks.length) this.#body.deleteRow(-1);
    while (this.#body.rows.length < landmarks.length) this.#body.append(make("tr", ...COLUMNS.map(() => make("td"))));
    for (const [index, landmark] of landmarks.entries()) {
      const cells = this.#body.rows[index]?.cells ?? [];
      for (const [column, text] of rowOf(landmark).entries()) write(/** @type {Element} */ (cells[column]), text);
    }
  }
}

/** @param {LandmarkRow} landmark */
function rowOf({ id, x_m: x, y_m: y, cov_m2: covariance, hits, misses }) {
  const uncertain = 100 * largestSigma(covariance);
  return [String(id), fixed(x, 2), fixed(y, 2), fixed(uncertain, 1), String(hits), String(misses)];
}

customElements.define("landmark-table", LandmarkTable);
