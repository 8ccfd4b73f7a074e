// The page that measures hearing: its parts, and the runs that they all show.

import "../theme.js";
import "../panels/banner-stack.js";
import "../panels/link-chip.js";
import "../panels/live-region.js";
import "../panels/login-view.js";
import "../panels/notice-toasts.js";
import "../panels/stop-button.js";
import "../panels/theme-toggle.js";
import "./quality-form.js";
import "./quality-list.js";
import "./quality-result.js";
import { enter } from "../entrance.js";
import { Panel } from "../panel.js";
import { Session } from "../session.js";
import { stopByKeys } from "../stop-keys.js";
import { Runs } from "./runs.js";

const SHOW_MS = 200;

const session = new Session();
const runs = new Runs(session);
const panels = [...document.querySelectorAll("*")].filter((element) => element instanceof Panel);
for (const panel of panels) {
  if ("watch" in panel && typeof panel.watch === "function") panel.watch(runs);
  panel.join(session);
}

setInterval(() => {
  const { view } = session;
  document.body.classList.toggle("is-lost", !view.up);
  for (const panel of panels) panel.show(view);
}, SHOW_MS);

stopByKeys(session);
enter(session);
