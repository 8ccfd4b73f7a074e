// Element <calibration-steps>: step indicator of a wizard.

import { make, mark } from "../ui/element.js";
import { t } from "../ui/texts.js";
import { hashOf } from "./router.js";
import { WizardStep } from "./wizard-step.js";

const STEPS = /** @type {const} */ ([t("steps.board"), t("steps.views"), t("steps.review"), t("steps.in_use")]);

class CalibrationSteps extends WizardStep {
  #items = STEPS.map((name, index) =>
    make("li", make("a", make("span.step-number", { "aria-hidden": "true" }, String(index + 1)), name)),
  );

  /** @override */
  build() {
    this.append(make("ol", { "aria-label": t("steps.steps") }, ...this.#items));
  }

  /** @override */
  draw() {
    const { place, calibration } = this.model;
    this.hidden = place.at === "home" || place.at === "microphones";
    const accepted = calibration !== null && this.model.used;
    const present = place.at === "new" ? 0 : place.at === "capture" ? 1 : accepted ? 3 : 2;
    this.#items.forEach((item, index) => {
      const link = /** @type {HTMLElement} */ (item.firstElementChild);
      mark(link, "aria-current", index === present ? "step" : null);
      mark(item, "data-done", index < present);
      const to = index === 1 ? "capture" : "review";
      const reach = "id" in place && index > 0 && index !== present && (index < 3 || accepted);
      mark(link, "href", reach ? hashOf({ at: to, id: place.id }) : null);
    });
  }
}

customElements.define("calibration-steps", CalibrationSteps);
