// Entry point of the people page: enrollment, known people, and the choice of person.

import "../ui/theme.js";
import "../panels/banner-stack.js";
import "../panels/link-chip.js";
import "../panels/live-region.js";
import "../panels/login-view.js";
import "../panels/notice-toasts.js";
import "../panels/stop-button.js";
import "../panels/theme-toggle.js";
import "./people-known.js";
import "./people-enrollment.js";
import { stopByKeys } from "../drive/stop-keys.js";
import { Session } from "../net/session.js";
import { enter } from "../ui/boot.js";
import { Panel } from "../ui/panel.js";
import { EnrollmentModel } from "./enrollment-model.js";

const SHOW_MS = 100;

const session = new Session();
const enrollments = new EnrollmentModel(session);
const panels = [...document.querySelectorAll("*")].filter((element) => element instanceof Panel);
for (const panel of panels) {
  if ("watch" in panel && typeof panel.watch === "function") panel.watch(enrollments);
  panel.join(session);
}

setInterval(() => {
  const { view } = session;
  document.body.classList.toggle("is-lost", !view.up);
  for (const panel of panels) panel.show(view);
}, SHOW_MS);

stopByKeys(session);
enter(session);
