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
import { intentionOf, takesText } from "../keys.js";
import { remembered } from "../memory.js";
import { Panel } from "../panel.js";
import { Session } from "../session.js";
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

addEventListener(
  "keydown",
  (event) => {
    const typing = takesText(event.composedPath()[0]);
    const intention = intentionOf(event, { typing, singleKeys: remembered("single-keys", "on") === "on" });
    if (intention?.does !== "stop") return;
    if (event.key !== "Escape") event.preventDefault();
    if (!event.repeat) session.stop();
  },
  true,
);

addEventListener("keyup", (event) => {
  // Space stops; it must not press the button in focus besides
  if (event.code === "Space" && remembered("single-keys", "on") === "on" && !takesText(event.composedPath()[0]))
    event.preventDefault();
});

/** The token of a printed link: used at once, and wiped from the address. */
function enterByLink() {
  const token = new URLSearchParams(location.hash.slice(1)).get("t");
  if (!token) return false;
  history.replaceState(null, "", location.pathname + location.search);
  void (
    /** @type {import("../panels/login-view.js").LoginView} */ (document.querySelector("login-view")).enter(token)
  );
  return true;
}

if (!enterByLink()) void session.begin();
