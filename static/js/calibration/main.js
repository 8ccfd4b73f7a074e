// The calibration page: opens the step of a wizard that the address names.

import { t } from "../ui/texts.js";
import "./calibration-capture.js";
import "./calibration-home.js";
import "./calibration-microphones.js";
import "./calibration-review.js";
import "./calibration-setup.js";
import "./steps.js";
import { make } from "../ui/element.js";
import { unlessPressed } from "../ui/press.js";
import { CalibrationModel } from "./calibration-model.js";
import { placeOf } from "./router.js";

/** @import { WizardStep } from "./wizard-step.js" */

const SHOW_MS = 200;
const NAMES = {
  home: t("main.calibrate"),
  new: t("main.which_board"),
  capture: t("main.views"),
  review: t("main.review"),
  microphones: t("main.microphones"),
};
const STEPS = {
  home: "calibration-home",
  new: "calibration-setup",
  capture: "calibration-capture",
  review: "calibration-review",
  microphones: "calibration-microphones",
};

/** @param {import("../net/session.js").Session} session */
export function create(session) {
  const model = new CalibrationModel(session);
  const indicator = /** @type {WizardStep} */ (document.createElement("calibration-steps"));
  const steps = Object.values(STEPS).map((name) => /** @type {WizardStep} */ (document.createElement(name)));
  for (const step of steps) step.hidden = true;
  let here = false; // this page is shown
  let opened = "";
  let due = false;

  /** Open the step that the address names, once its session has arrived. */
  function show() {
    due = false;
    const { place, calibration } = model;
    const waits = "id" in place && calibration === null;
    const wanted = waits || !session.hello || !here ? "" : STEPS[place.at];
    const key = `${wanted} ${JSON.stringify({ ...place, at: wanted })}`;
    unlessPressed(indicator, () => indicator.draw());
    for (const step of steps) {
      const open = step.localName === wanted;
      if (!open && !step.hidden) step.left();
      step.hidden = !open;
      if (!open) continue;
      if (key !== opened) {
        step.closest("main")?.scrollTo(0, 0); // a step begins at its top
        step.opened();
      }
      unlessPressed(step, () => step.draw());
    }
    if (key !== opened && here) document.title = `${NAMES[place.at]} · Beckon`;
    opened = key;
  }

  function soon() {
    if (!due) requestAnimationFrame(show);
    due = true;
  }

  const follow = () => void model.open(placeOf(location.hash));
  model.onChange(soon);
  session.on("hello", () => here && follow());
  setInterval(() => here && show(), SHOW_MS);
  return {
    element: make("div.stack.wizard", indicator, ...steps),
    model,
    moved: follow,
    opened() {
      here = true;
      follow();
    },
    left() {
      here = false;
      show(); // the step lets its camera go
      void model.open({ at: "home" });
    },
  };
}
