// Element <exports-card>: download links of the calibration in several formats.

import { cardHead, icon, isNew, make } from "../ui/element.js";
import { t } from "../ui/texts.js";
import * as api from "./api.js";

/** @import { Calibration } from "./types.js" */

const FORMS = {
  camera: [
    ["ros", "ROS", t("exports-card.camera_info_yaml")],
    ["opencv", "OpenCV", "FileStorage YAML"],
    ["kalibr", "Kalibr", "camchain YAML"],
    ["json", "Beckon", t("exports-card.json_with_covariance")],
  ],
  laser: [
    ["json", "Beckon", t("exports-card.json_with_covariance")],
    ["urdf", "URDF", t("exports-card.fixed_joint")],
    ["static_transform", "ROS", t("exports-card.static_transform")],
    ["matrix", t("exports-card.matrix"), t("exports-card.4_4_both_ways")],
  ],
};

export class ExportsCard extends HTMLElement {
  #list = make("ul.exports");

  connectedCallback() {
    if (this.children.length) return;
    this.classList.add("card");
    this.append(cardHead(t("exports-card.take_it_along")), this.#list);
  }

  /** @param {Calibration} calibration */
  show({ id, kind, solution }) {
    this.hidden = solution === null;
    const bent = typeof solution?.["k3"] === "number";
    if (!isNew(this, id, bent)) return;
    const forms = [
      ...FORMS[kind],
      ["all", t("exports-card.everything"), t("exports-card.pictures_corners_solution_zip")],
    ];
    this.#list.replaceChildren(
      ...forms.map(([form = "", name = "", says = ""]) =>
        make("li", bent && form === "kalibr" ? NO_KALIBR() : link(api.exported(id, form), name, says)),
      ),
    );
  }
}

/** @param {string} href @param {string} name @param {string} says */
function link(href, name, says) {
  const words = make("span", make("span.export-name", name), make("span.note", says));
  return make("a.export", { href, download: "" }, icon("download"), words);
}

const NO_KALIBR = () => make("p.export.note", t("exports-card.kalibr_s_form_has_no_place"));

customElements.define("exports-card", ExportsCard);
