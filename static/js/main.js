// Entry point of the console page: creates the session, joins the panels and redraws them.

import "./panels/answer-button.js";
import "./panels/app-menu.js";
import "./panels/camera-view.js";
import "./panels/coach-marks.js";
import "./panels/command-chips.js";
import "./panels/command-line.js";
import "./panels/command-status.js";
import "./panels/drive-pad.js";
import "./panels/estimate-card.js";
import "./panels/flat-map.js";
import "./panels/gamepad-sheet.js";
import "./panels/hearing-card.js";
import "./panels/history-list.js";
import "./panels/key-sheet.js";
import "./panels/lease-chip.js";
import "./panels/map-card.js";
import "./panels/map-switch.js";
import "./panels/mark-sheets.js";
import "./panels/own-navigation-card.js";
import "./panels/pending-command-card.js";
import "./panels/place-list.js";
import "./panels/place-view.js";
import "./panels/playback-bar.js";
import "./panels/robot-badge.js";
import "./panels/route-card.js";
import "./panels/scene-view.js";
import "./panels/sign-in-sheet.js";
import "./panels/slam-card.js";
import "./panels/tab-card.js";
import "./panels/tour-guide.js";
import "./panels/view-tabs.js";
import "./panels/voice-button.js";
import { OperatorInput } from "./drive/operator-input.js";
import { startPage } from "./page.js";

/**
 * @template {HTMLElement} T
 * @param {string} tag
 * @returns {T}
 */
const part = (tag) => /** @type {T} */ (document.querySelector(tag));

/**
 * Open the settings; their sheet is loaded when it is first wanted.
 * @param {import("./net/session.js").Session} session
 */
async function openSettings(session) {
  const { SettingsSheet } = await import("./settings/settings-sheet.js");
  const known = document.querySelector("settings-sheet");
  const sheet = known instanceof SettingsSheet ? known : new SettingsSheet();
  if (sheet !== known) {
    sheet.hidden = true;
    document.querySelector("sign-in-sheet")?.after(sheet);
    sheet.join(session);
  }
  sheet.toggle();
}

/** @param {import("./net/session.js").Session} session @param {import("./shell/shell.js").Shell} shell */
function begin(session, shell) {
  const operatorInput = new OperatorInput(session);
  shell.onPage((row) => {
    operatorInput.enable(row.path === "");
    /** @type {import("./panels/page-menu.js").PageMenu} */ (part("page-menu")).open(row);
  });
  /** @type {import("./panels/drive-pad.js").DrivePad} */ (part("drive-pad")).hold(operatorInput);
  /** @type {import("./panels/scene-view.js").SceneView} */ (part("scene-view")).whenLoaded((inner) =>
    operatorInput.listenTo(inner),
  );
  operatorInput.toWords = () =>
    /** @type {import("./panels/command-line.js").CommandLine} */ (part("command-line")).take();
  operatorInput.toTalk = (down) =>
    /** @type {import("./panels/voice-button.js").VoiceButton} */ (part("voice-button")).hold(down);
  operatorInput.toBegin = (id) => void session.pendingCommand("begin", id);
  const gamepadSheet = /** @type {import("./panels/gamepad-sheet.js").GamepadSheet} */ (part("gamepad-sheet"));
  gamepadSheet.hold(operatorInput.gamepad);
  operatorInput.toHelp = () => dispatchEvent(new Event("show-keys"));
  const sheets = {
    "show-keys": () => /** @type {import("./panels/key-sheet.js").KeySheet} */ (part("key-sheet")).toggle(),
    "show-gamepad": () => gamepadSheet.toggle(),
    "show-sign-ins": () =>
      /** @type {import("./panels/sign-in-sheet.js").SignInSheet} */ (part("sign-in-sheet")).toggle(),
    "show-settings": () => void openSettings(session),
  };
  for (const [event, open] of Object.entries(sheets))
    addEventListener(event, () => {
      operatorInput.letGo();
      open();
    });
  addEventListener("show-hints", () =>
    /** @type {import("./panels/coach-marks.js").CoachMarks} */ (part("coach-marks")).begin(),
  );
  addEventListener("single-keys", (event) => {
    operatorInput.singleKeys = /** @type {CustomEvent<boolean>} */ (event).detail;
  });
  session.on("hello", ({ robot }) => {
    document.body.classList.toggle("is-recording", !robot.drives);
    document.body.classList.toggle("is-dry-run", robot.dry_run);
  });
  session.on("heard", (view) => operatorInput.show(view));
}

startPage(begin);
