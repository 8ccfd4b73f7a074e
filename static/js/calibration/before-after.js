// Element <before-after>: one view as taken and undistorted, with a movable divider.

import { cardHead, isNew, make, mark, write } from "../ui/element.js";
import { t } from "../ui/texts.js";
import * as api from "./api.js";

/** @import { Calibration } from "./types.js" */

export class BeforeAfter extends HTMLElement {
  #before = make("img", { alt: t("before-after.as_the_camera_took_it"), draggable: "false" });
  #after = make("img.after", { alt: t("before-after.straightened"), draggable: "false" });
  #line = make("span.divide", { "aria-hidden": "true" });
  #slider = make("input", {
    type: "range",
    min: "0",
    max: "100",
    value: "50",
    "aria-label": t("before-after.straightened_from_here_on"),
  });
  #box = make(
    "div.both",
    this.#before,
    this.#after,
    this.#line,
    make("span.both-tag.is-left", t("before-after.as_taken")),
    make("span.both-tag.is-right", t("before-after.straightened")),
    this.#slider,
  );
  #which = make("p.note");

  connectedCallback() {
    if (this.children.length) return;
    this.classList.add("card");
    this.append(cardHead(t("before-after.before_and_after"), this.#which), this.#box);
    this.#slider.addEventListener("input", () => this.#place());
    this.#place();
  }

  /** @param {Calibration} calibration @param {string} name of the view to show */
  show({ id, size, solution, kind, progress }, name) {
    this.hidden = kind !== "camera" || !solution || !name;
    if (this.hidden) return;
    if (!isNew(this, id, name, progress.views, solution?.["rms_px"])) return;
    if (size) this.#box.style.aspectRatio = `${size[0]} / ${size[1]}`;
    write(this.#which, name);
    mark(this.#before, "src", api.thumbnail(id, name, "full"));
    mark(
      this.#after,
      "src",
      `${api.thumbnail(id, name, "corrected")}&of=${encodeURIComponent(String(solution?.["rms_px"]))}`,
    );
  }

  #place() {
    const at = `${this.#slider.value}%`;
    this.#after.style.clipPath = `inset(0 0 0 ${at})`;
    this.#line.style.left = at;
    mark(
      this.#slider,
      "aria-valuetext",
      t("before-after.value_straightened", { value: 100 - Number(this.#slider.value) }),
    );
  }
}

customElements.define("before-after", BeforeAfter);
