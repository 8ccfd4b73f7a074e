// Element <estimate-line>: the estimated pose in one line below the map; a press opens the estimate.

import { make, write } from "../ui/element.js";
import { degrees, metres, sigmas, spread, turnSpread } from "../ui/format.js";
import { Panel } from "../ui/panel.js";
import { t } from "../ui/texts.js";

/** @import { View } from "../net/session.js" */

class EstimateLine extends Panel {
  #values = [0, 1, 2].map(() => ({ value: make("span.where-value", "–"), sigma: make("span.figure-sigma") }));
  #lost = make("span.where-lost", { hidden: true }, t("estimate-line.lost"));
  #button = make("button.row.where", { title: t("estimate-line.where_the_robot_believes_it_is") }, this.#lost);

  /** @override */
  build() {
    for (const [index, { value, sigma }] of this.#values.entries()) {
      const name = ["x ", "y ", t("estimate-line.heading")][index];
      this.#button.append(make("span.where-part", make("span.where-name", name), value, " ", sigma));
    }
    this.#button.addEventListener("click", () => dispatchEvent(new CustomEvent("open-view", { detail: "estimate" })));
    this.append(this.#button);
  }

  /** @override @param {View} view */
  show({ state, up }) {
    this.classList.toggle("is-old", !up);
    if (!state) return;
    const { x_m, y_m, heading_rad, cov } = state.pose;
    const lost = state.floor.lost !== null; // then no spread holds
    this.#lost.hidden = !lost;
    const sigma = sigmas(cov);
    /** @type {Array<[string, string]>} */
    const said = [
      [metres(x_m), spread(sigma.x)],
      [metres(y_m), spread(sigma.y)],
      [degrees(heading_rad, 1), turnSpread(sigma.heading)],
    ];
    for (const [index, part] of this.#values.entries()) {
      const [value, spreads] = said[index] ?? ["", ""];
      write(part.value, value);
      write(part.sigma, lost ? "± ?" : spreads);
    }
  }
}

customElements.define("estimate-line", EstimateLine);
