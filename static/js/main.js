// Entry point of the console page: creates the session, joins the panels and redraws them.

import "./ui/theme.js";
import "./panels/answer-button.js";
import "./panels/app-menu.js";
import "./panels/banner-stack.js";
import "./panels/camera-view.js";
import "./panels/coach-marks.js";
import "./panels/command-chips.js";
import "./panels/command-line.js";
import "./panels/command-status.js";
import "./panels/drive-pad.js";
import "./panels/estimate-card.js";
import "./panels/first-play.js";
import "./panels/hearing-card.js";
import "./panels/pending-command-card.js";
import "./panels/key-sheet.js";
import "./panels/lease-chip.js";
import "./panels/link-chip.js";
import "./panels/live-region.js";
import "./panels/login-view.js";
import "./panels/map-card.js";
import "./panels/notice-toasts.js";
import "./panels/place-view.js";
import "./panels/playback-bar.js";
import "./panels/record-card.js";
import "./panels/robot-badge.js";
import "./panels/scene-view.js";
import "./panels/slam-card.js";
import "./panels/stop-button.js";
import "./panels/theme-toggle.js";
import "./panels/view-tabs.js";
import "./panels/voice-button.js";
import { OperatorInput } from "./drive/operator-input.js";
import { Session } from "./net/session.js";
import { enter } from "./ui/boot.js";
import { Panel } from "./ui/panel.js";

const SHOW_MS = 200; // ages grow without news, and a browser that draws slowly must not keep quiet about it

/**
 * @template {HTMLElement} T
 * @param {string} tag
 * @returns {T}
 */
const part = (tag) => /** @type {T} */ (document.querySelector(tag));

const session = new Session();
const operatorInput = new OperatorInput(session);
const panels = [...document.querySelectorAll("*")].filter((element) => element instanceof Panel);
for (const panel of panels) panel.join(session);

/** @type {import("./panels/drive-pad.js").DrivePad} */ (part("drive-pad")).hold(operatorInput);
/** @type {import("./panels/scene-view.js").SceneView} */ (part("scene-view")).whenLoaded((inner) =>
  operatorInput.listenTo(inner),
);
operatorInput.toWords = () =>
  /** @type {import("./panels/command-line.js").CommandLine} */ (part("command-line")).take();
operatorInput.toTalk = (down) =>
  /** @type {import("./panels/voice-button.js").VoiceButton} */ (part("voice-button")).hold(down);
operatorInput.toBegin = (id) => void session.beginPendingCommand(id);
operatorInput.toHelp = () => {
  operatorInput.letGo();
  /** @type {import("./panels/key-sheet.js").KeySheet} */ (part("key-sheet")).toggle();
};
addEventListener("show-keys", () => operatorInput.toHelp());
addEventListener("show-hints", () =>
  /** @type {import("./panels/coach-marks.js").CoachMarks} */ (part("coach-marks")).begin(),
);
addEventListener("single-keys", (event) => {
  operatorInput.singleKeys = /** @type {CustomEvent<boolean>} */ (event).detail;
});

session.on("hello", ({ robot }) => document.body.classList.toggle("is-recording", !robot.drives));

let shown = -1;
let shownAt = -Infinity;

function show() {
  [shown, shownAt] = [session.state?.seq ?? 0, performance.now()];
  const { view } = session;
  document.body.classList.toggle("is-lost", !view.up);
  for (const panel of panels) panel.show(view);
}

function beat() {
  requestAnimationFrame(beat);
  if ((session.state?.seq ?? 0) !== shown) show();
}

session.on("heard", (view) => operatorInput.show(view));
requestAnimationFrame(beat);
setInterval(() => performance.now() - shownAt >= SHOW_MS && show(), SHOW_MS);

enter(session);
