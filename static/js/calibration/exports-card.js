// Element <exports-card>: download links of the calibration in several formats.

import { icon, make } from "../ui/element.js";
import * as api from "./api.js";

/** @typedef {import("./types.js").Calibration} Calibration */

const FORMS = {
  camera: [
    ["ros", "ROS", "camera_info YAML"],
    ["opencv", "OpenCV", "FileStorage YAML"],
    ["kalibr", "Kalibr", "camchain YAML"],
    ["json", "Beckon", "JSON with covariance"],
  ],
  laser: [
    ["json", "Beckon", "JSON with covariance"],
    ["urdf", "URDF", "fixed joint"],
    ["static_transform", "ROS", "static transform"],
    ["matrix", "Matrix", "4 × 4, both ways"],
  ],
};

export class ExportsCard extends HTMLElement {
  #list = make("ul", { class: "exports" });
  #of = "";

  connectedCallback() {
    if (this.children.length) return;
    this.classList.add("card");
    this.append(make("div", { class: "card-head" }, make("h2", { class: "card-title" }, "Take it along")), this.#list);
  }

  /** @param {Calibration} calibration */
  show({ id, kind, solution }) {
    this.hidden = solution === null;
    const bent = typeof solution?.["k3"] === "number";
    const of = `${id} ${bent}`;
    if (of === this.#of) return;
    this.#of = of;
    const forms = [...FORMS[kind], ["all", "Everything", "pictures, corners, solution (zip)"]];
    this.#list.replaceChildren(
      ...forms.map(([form = "", name = "", says = ""]) =>
        make("li", {}, bent && form === "kalibr" ? NO_KALIBR() : link(api.exported(id, form), name, says)),
      ),
    );
  }
}

/**
 * @param {string} href
 * @param {string} name
 * @param {string} says
 */
function link(href, name, says) {
  const words = make("span", {}, make("span", { class: "export-name" }, name), make("span", { class: "note" }, says));
  return make("a", { class: "export", href, download: "" }, icon("download"), words);
}

const NO_KALIBR = () =>
  make("p", { class: "export note" }, "Kalibr’s form has no place for k₃, which this camera needs.");

customElements.define("exports-card", ExportsCard);
