// The page of the wizards: its parts, what joins them, and which room is open.

import "../theme.js";
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
import { enter } from "../entrance.js";
import { Panel } from "../panel.js";
import { Session } from "../session.js";
import { stopByKeys } from "../stop-keys.js";
import { Bench } from "./bench.js";
import { Room } from "./room.js";

const SHOW_MS = 200;
const NAMES = {
  home: "Calibrate",
  new: "Which board?",
  capture: "Views",
  review: "Review",
  microphones: "Microphones",
};
const ROOMS = {
  home: "calibration-home",
  new: "calibration-setup",
  capture: "calibration-capture",
  review: "calibration-review",
  microphones: "calibration-microphones",
};

const session = new Session();
const bench = new Bench(session);
const panels = [...document.querySelectorAll("*")].filter((element) => element instanceof Panel);
const rooms = panels.filter((panel) => panel instanceof Room);
for (const panel of panels)
  if (panel instanceof Room) panel.enter(bench);
  else panel.join(session);

const steps = /** @type {Room} */ (document.querySelector("calibration-steps"));
let opened = "";

/** Opens the room that the address asks for, once what it shows has come. */
function show() {
  const { place, calibration } = bench;
  const waits = "id" in place && calibration === null;
  const wanted = waits || !session.hello ? "" : ROOMS[place.at];
  const key = `${wanted} ${JSON.stringify({ ...place, at: wanted })}`;
  steps.draw();
  for (const room of rooms) {
    if (room === steps) continue;
    const open = room.localName === wanted;
    if (!open && !room.hidden) room.left();
    room.hidden = !open;
    if (!open) continue;
    if (key !== opened) room.opened();
    room.draw();
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

bench.onChange(soon);
session.on("hello", soon);
setInterval(beat, SHOW_MS);

stopByKeys(session);

document.querySelector(".skip")?.addEventListener("click", (event) => {
  event.preventDefault();
  /** @type {HTMLElement | null} */ (document.querySelector("main :is(a, button, input):not([hidden])"))?.focus();
});

enter(session);
