// Entry point of the calibration page: creates the model, joins the panels and opens the current step.

import "./calibration-capture.js";
import "./calibration-home.js";
import "./calibration-microphones.js";
import "./calibration-review.js";
import "./calibration-setup.js";
import "./steps.js";
import { startPage } from "../page.js";
import { CalibrationModel } from "./calibration-model.js";
import { WizardStep } from "./wizard-step.js";

const SHOW_MS = 200;
const NAMES = {
  home: "Calibrate",
  new: "Which board?",
  capture: "Views",
  review: "Review",
  microphones: "Microphones",
};
const STEPS = {
  home: "calibration-home",
  new: "calibration-setup",
  capture: "calibration-capture",
  review: "calibration-review",
  microphones: "calibration-microphones",
};

/**
 * @param {import("../net/session.js").Session} session
 * @param {CalibrationModel} model
 */
function begin(session, model) {
  const steps = [...document.querySelectorAll("*")].filter((element) => element instanceof WizardStep);
  const indicator = /** @type {WizardStep} */ (document.querySelector("calibration-steps"));
  let opened = "";
  let due = false;

  /** Open the step that the address names, once its session has arrived. */
  function show() {
    due = false;
    const { place, calibration } = model;
    const waits = "id" in place && calibration === null;
    const wanted = waits || !session.hello ? "" : STEPS[place.at];
    const key = `${wanted} ${JSON.stringify({ ...place, at: wanted })}`;
    indicator.draw();
    for (const step of steps) {
      if (step === indicator) continue;
      const open = step.localName === wanted;
      if (!open && !step.hidden) step.left();
      step.hidden = !open;
      if (!open) continue;
      if (key !== opened) step.opened();
      step.draw();
    }
    if (key !== opened) document.title = `${NAMES[place.at]} · Beckon`;
    opened = key;
  }

  function soon() {
    if (!due) requestAnimationFrame(show);
    due = true;
  }

  model.onChange(soon);
  session.on("hello", soon);
  setInterval(show, SHOW_MS);
}

document.querySelector(".skip")?.addEventListener("click", (event) => {
  event.preventDefault();
  /** @type {HTMLElement | null} */ (document.querySelector("main :is(a, button, input):not([hidden])"))?.focus();
});

startPage({ model: (session) => new CalibrationModel(session), begin });
