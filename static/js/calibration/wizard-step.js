// Base class of the steps of the calibration page.

import { Panel } from "../ui/panel.js";

/** @typedef {import("./calibration-model.js").CalibrationModel} CalibrationModel */

export class WizardStep extends Panel {
  /** @type {CalibrationModel | null} */
  #model = null;

  /** @returns {CalibrationModel} */
  get model() {
    if (!this.#model) throw new Error(`<${this.localName}> was used before it was given a model.`);
    return this.#model;
  }

  /** @param {CalibrationModel} model */
  watch(model) {
    this.#model = model;
  }

  /** Called when this step is opened. */
  opened() {}

  /** Called when another step is opened. */
  left() {}

  /** Called while it is open, whenever something changed and at least five times a second. */
  draw() {}
}
