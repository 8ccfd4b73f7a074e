// Element <playback-bar>: play, pause, speed and position of a recording.

import { icon, make, mark, redraw, write } from "../ui/element.js";
import { duration } from "../ui/format.js";
import { Panel } from "../ui/panel.js";

/** @typedef {import("../net/session.js").View} View */

const SPEEDS = [0.5, 1, 2, 5, 10];
const STEPS = 1000;
const SETTLE_MS = 600; // after a seek the slider waits for the recording to arrive there

class PlaybackBar extends Panel {
  #icon = icon("pause");
  #play = make("button", { type: "button", class: "button primary play", "aria-label": "Pause" }, this.#icon);
  #seek = make("input", {
    type: "range",
    class: "seek",
    min: "0",
    max: String(STEPS),
    step: "1",
    value: "0",
    "aria-label": "Place in the recording",
  });
  #time = make("span", { class: "playback-time" });
  #speeds = make(
    "div",
    { class: "presets", role: "group", "aria-label": "Playback speed" },
    ...SPEEDS.map((times) =>
      make("button", { type: "button", class: "preset", "data-speed": String(times) }, `${times}×`),
    ),
  );
  #movedAt = -Infinity;
  #length = 0;

  /** @override */
  build() {
    this.classList.add("card");
    this.setAttribute("role", "region");
    this.setAttribute("aria-label", "Playback");
    this.append(this.#play, this.#seek, this.#time, this.#speeds);
    this.session.on("hello", ({ robot }) => {
      this.hidden = !robot.capabilities.includes("replay");
      this.#length = robot.duration_s ?? 0;
    });
    this.#play.addEventListener("click", () => {
      void this.session.playback(this.session.state?.robot.running ? "pause" : "play");
    });
    this.#seek.addEventListener("input", () => {
      this.#movedAt = performance.now();
      this.#tell(Number(this.#seek.value) / STEPS);
    });
    this.#seek.addEventListener("change", () => {
      this.#movedAt = performance.now();
      void this.session.playback("seek", Number(this.#seek.value) / STEPS);
    });
    for (const button of this.#speeds.querySelectorAll("button")) {
      button.addEventListener("click", () => void this.session.playback("speed", Number(button.dataset["speed"])));
    }
  }

  /**
   * @override
   * @param {View} view
   */
  show({ state, up, hello }) {
    if (this.hidden || !state) return;
    const may = up && hello?.you.role !== "viewer";
    for (const control of this.querySelectorAll("button, input")) mark(control, "disabled", !may);
    const { running, progress, speed } = state.robot;
    const ended = !running && progress !== null && progress >= 1;
    redraw(this.#icon, running ? "pause" : "play");
    mark(this.#play, "aria-label", running ? "Pause" : ended ? "Play again" : "Play");
    for (const button of this.#speeds.querySelectorAll("button")) {
      mark(button, "aria-pressed", String(Number(button.dataset["speed"]) === speed));
    }
    if (performance.now() - this.#movedAt < SETTLE_MS) return;
    const place = progress ?? 0;
    this.#seek.value = String(Math.round(place * STEPS));
    this.#tell(place);
  }

  /** @param {number} place 0..1 */
  #tell(place) {
    this.#seek.style.setProperty("--place", `${place * 100}%`);
    const text = `${duration(place * this.#length)} of ${duration(this.#length)}`;
    write(this.#time, text);
    mark(this.#seek, "aria-valuetext", text);
  }
}

customElements.define("playback-bar", PlaybackBar);
