// Base class of the steps of the calibration page.

import { PagePanel } from "../ui/panel.js";

/**
 * `draw()` is called while the step is open, whenever something changed and at least five times a second.
 * @extends {PagePanel<import("./calibration-model.js").CalibrationModel>}
 */
export class WizardStep extends PagePanel {
  /** @override */
  changed() {} // the page draws the step that is open

  opened() {}

  left() {}
}
