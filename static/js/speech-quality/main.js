// Entry point of the speech quality page.

import "../ui/theme.js";
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
import { stopByKeys } from "../drive/stop-keys.js";
import { Session } from "../net/session.js";
import { enter } from "../ui/boot.js";
import { Panel } from "../ui/panel.js";
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
