// Element <poses-card>: where the board was in every view, in the camera's frame, with standard deviations.

import { cardHead, isNew, make } from "../ui/element.js";
import { t } from "../ui/texts.js";
import { poseRows } from "./figures.js";

/** @import { Calibration } from "./types.js" */

export class PosesCard extends HTMLElement {
  #body = make("tbody");

  connectedCallback() {
    if (this.children.length) return;
    this.classList.add("card");
    const names = [t("poses-card.view"), t("poses-card.place_mm"), t("poses-card.turn_degrees")];
    const head = make("tr", ...names.map((name) => make("th", { scope: "col" }, name)));
    this.append(
      cardHead(t("poses-card.poses_of_the_board")),
      make("table.values", make("thead", head), this.#body),
      make("p.note", t("poses-card.in_the_camera_s_frame")),
    );
  }

  /** @param {Calibration} calibration */
  show({ solution, kind }) {
    const rows = poseRows(kind === "camera" ? (solution?.["views"] ?? []) : []);
    this.hidden = rows.length === 0;
    if (!isNew(this, rows)) return;
    this.#body.replaceChildren(
      ...rows.map(([name, place, turned]) =>
        make("tr", make("th", { scope: "row" }, name), make("td", place), make("td", turned)),
      ),
    );
  }
}

customElements.define("poses-card", PosesCard);
