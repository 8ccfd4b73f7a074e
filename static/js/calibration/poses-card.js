// Element <poses-card>: where the board was in every view, in the camera's frame, with standard deviations.

import { make } from "../ui/element.js";
import { fixed } from "../ui/format.js";
import { t } from "../ui/texts.js";

/** @typedef {import("./types.js").Calibration} Calibration */
/** @typedef {{rvec_rad: number[], tvec_m: number[], sd_rotation_rad: number[], sd_translation_m: number[]}} BoardPose */

const DEGREES = 180 / Math.PI;

export class PosesCard extends HTMLElement {
  #body = make("tbody");
  #drawn = "";

  connectedCallback() {
    if (this.children.length) return;
    this.classList.add("card");
    const names = [t("poses-card.view"), t("poses-card.place_mm"), t("poses-card.turn_degrees")];
    const head = make("tr", {}, ...names.map((name) => make("th", { scope: "col" }, name)));
    this.append(
      make("div", { class: "card-head" }, make("h2", { class: "card-title" }, t("poses-card.poses_of_the_board"))),
      make("table", { class: "values" }, make("thead", {}, head), this.#body),
      make("p", { class: "note" }, t("poses-card.in_the_camera_s_frame")),
    );
  }

  /** @param {Calibration} calibration */
  show({ solution, kind }) {
    /** @type {Array<{image: string, used: boolean, pose?: BoardPose}>} */
    const views = kind === "camera" ? (solution?.["views"] ?? []) : [];
    const rows = poseRows(views);
    this.hidden = rows.length === 0;
    const drawn = JSON.stringify(rows);
    if (drawn === this.#drawn) return;
    this.#drawn = drawn;
    this.#body.replaceChildren(
      ...rows.map(([name, place, turned]) =>
        make("tr", {}, make("th", { scope: "row" }, name), make("td", {}, place), make("td", {}, turned)),
      ),
    );
  }
}

/**
 * Name, place and turn of every view that takes part, each number ± its standard deviation.
 * @param {Array<{image: string, used: boolean, pose?: BoardPose}>} views
 * @returns {[string, string, string][]}
 */
export function poseRows(views) {
  return views.flatMap(({ image, used, pose }) =>
    used && pose
      ? [[image, listed(pose.tvec_m, pose.sd_translation_m, 1e3), listed(pose.rvec_rad, pose.sd_rotation_rad, DEGREES)]]
      : [],
  );
}

/** @param {number[]} values @param {number[]} sds @param {number} unit of the values shown */
const listed = (values, sds, unit) =>
  values.map((value, axis) => `${fixed(unit * value, 1)} ± ${fixed(unit * (sds[axis] ?? NaN), 2)}`).join(", ");

customElements.define("poses-card", PosesCard);
