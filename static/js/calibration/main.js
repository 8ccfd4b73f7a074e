// Entry point of the calibration page: creates the model, joins the panels and opens the current step.

import "../ui/theme.js";
import "../panels/banner-stack.js";
import "../panels/link-chip.js";
import "../panels/live-region.js";
import "../panels/login-view.js";
import "../panels/notice-toasts.js";
import "../panels/stop-button.js";
import "../panels/theme-toggle.js";
import "./calibration-capture.js";
import "./calibration-home.js";
import "./calibration-microphones.js";
import "./calibration-review.js";
import "./calibration-setup.js";
import "./steps.js";
import { stopByKeys } from "../drive/stop-keys.js";
import { Session } from "../net/session.js";
import { enter } from "../ui/boot.js";
import { Panel } from "../ui/panel.js";
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

const session = new Session();
const model = new CalibrationModel(session);
const panels = [...document.querySelectorAll("*")].filter((element) => element instanceof Panel);
const steps = panels.filter((panel) => panel instanceof WizardStep);
for (const panel of panels)
  if (panel instanceof WizardStep) panel.enter(model);
  else panel.join(session);

const indicator = /** @type {WizardStep} */ (document.querySelector("calibration-steps"));
let opened = "";

/** Open the step that the address names, once its session has arrived. */
function show() {
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

let due = false;
function soon() {
  if (due) return;
  due = true;
  requestAnimationFrame(() => {
    due = false;
    show();
  });
}

function beat() {
  const { view } = session;
  document.body.classList.toggle("is-lost", !view.up);
  for (const panel of panels) panel.show(view);
  show();
}

model.onChange(soon);
session.on("hello", soon);
setInterval(beat, SHOW_MS);

stopByKeys(session);

document.querySelector(".skip")?.addEventListener("click", (event) => {
  event.preventDefault();
  /** @type {HTMLElement | null} */ (document.querySelector("main :is(a, button, input):not([hidden])"))?.focus();
});

enter(session);
