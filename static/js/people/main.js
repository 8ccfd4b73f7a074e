// The page of people: teaching the robot who somebody is, and whom it comes to.

import "../theme.js";
import "../panels/banner-stack.js";
import "../panels/link-chip.js";
import "../panels/live-region.js";
import "../panels/login-view.js";
import "../panels/notice-toasts.js";
import "../panels/stop-button.js";
import "../panels/theme-toggle.js";
import "./people-known.js";
import "./people-lesson.js";
import { enter } from "../entrance.js";
import { Panel } from "../panel.js";
import { Session } from "../session.js";
import { stopByKeys } from "../stop-keys.js";
import { Lessons } from "./lessons.js";

const SHOW_MS = 100;

const session = new Session();
const lessons = new Lessons(session);
const panels = [...document.querySelectorAll("*")].filter((element) => element instanceof Panel);
for (const panel of panels) {
  if ("watch" in panel && typeof panel.watch === "function") panel.watch(lessons);
  panel.join(session);
}

setInterval(() => {
  const { view } = session;
  document.body.classList.toggle("is-lost", !view.up);
  for (const panel of panels) panel.show(view);
}, SHOW_MS);

stopByKeys(session);
enter(session);
