// Element <playback-bar>: play, pause, speed and position of a recording.

import { marks } from "../net/playback-api.js";
import { icon, make, mark, redraw, write } from "../ui/element.js";
import { duration } from "../ui/format.js";
import { Panel } from "../ui/panel.js";
import { t } from "../ui/texts.js";
import { ruler, Timeline } from "../ui/timeline.js";
import "./playback-part.js";
import "./playback-ways.js";

/** @import { View } from "../net/session.js" */

const SPEEDS = [0.1, 0.5, 1, 2, 5, 10, 20];
const STEPS = 10_000;
const ARROW_S = 5;
const STEERING = ":scope > button, .timeline > input, .mark, [data-speed]"; // what a viewer does not use
const TIMES = 6; // on the ruler
const SETTLE_MS = 600; // after a seek the slider waits for the recording to arrive there

class PlaybackBar extends Panel {
  #icon = icon("pause");
  #play = make("button.button.primary.play", { "aria-label": t("playback-bar.pause") }, this.#icon);
  #seek = make("input.seek", {
    type: "range",
    min: "0",
    max: String(STEPS),
    step: "1",
    value: "0",
    "aria-label": t("playback-bar.place_in_the_recording"),
  });
  #marks = make("div.marks");
  #ruler = make("div.ruler", { "aria-hidden": "true" });
  #line = make("div.timeline", this.#marks, this.#seek, this.#ruler);
  #timeline = new Timeline();
  #drawn = -1;
  #time = make("span.playback-time");
  #speeds = make(
    "div.presets",
    { role: "group", "aria-label": t("playback-bar.playback_speed") },
    ...SPEEDS.map((times) => make("button.preset", { "data-speed": String(times) }, `${times}×`)),
  );
  #movedAt = -Infinity;
  #length = 0;

  /** @override */
  build() {
    this.classList.add("card");
    this.setAttribute("role", "region");
    this.setAttribute("aria-label", t("playback-bar.playback"));
    const [ways, part] = ["playback-ways", "playback-part"].map((name) => document.createElement(name));
    this.append(
      this.#play,
      this.#line,
      this.#time,
      this.#speeds,
      /** @type {Node} */ (ways),
      /** @type {Node} */ (part),
    );
    this.session.on("hello", ({ robot }) => {
      this.hidden = !robot.capabilities.includes("replay");
      this.#length = robot.duration_s ?? 0;
      if (this.hidden || !this.#length) return;
      this.#timeline.begin(this.#length, robot.gaps_s);
      void marks().then(
        (found) => this.#timeline.add(found, this.#length),
        () => undefined, // without them it plays as well
      );
      const times = ruler(this.#length, TIMES).map((time) => {
        const label = make("span", duration(time));
        label.style.setProperty("--at", String(time / this.#length));
        return label;
      });
      this.#ruler.replaceChildren(...times);
    });
    this.#play.addEventListener("click", () => {
      void this.session.playback({ action: this.session.plays ? "pause" : "play" });
    });
    this.#seek.addEventListener("input", () => {
      this.#movedAt = performance.now();
      const place = Number(this.#seek.value) / STEPS;
      this.#tell(place);
      void this.session.scrub(place * this.#length); // the picture follows the finger
    });
    this.#seek.addEventListener("keydown", (event) => {
      const towards = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (!towards) return;
      event.preventDefault();
      this.session.seekBy(towards * ARROW_S);
    });
    this.#seek.addEventListener("pointermove", ({ offsetX }) => {
      const place = Math.min(1, Math.max(0, offsetX / this.#seek.clientWidth));
      this.#seek.title = duration(place * this.#length);
    });
    for (const button of this.#speeds.querySelectorAll("button")) {
      button.addEventListener(
        "click",
        () => void this.session.playback({ action: "speed", speed: Number(button.dataset["speed"]) }),
      );
    }
  }

  /** @override @param {View} view */
  show({ state, up, hello }) {
    if (this.hidden || !state) return;
    this.#timeline.saw(state);
    if (this.#drawn !== this.#timeline.revision) this.#draw();
    const may = up && hello?.you.role !== "viewer";
    for (const control of this.querySelectorAll(STEERING)) mark(control, "disabled", !may);
    const { running, progress, speed } = state.robot;
    const ended = !running && progress !== null && progress >= 1;
    redraw(this.#icon, running ? "pause" : "play");
    mark(
      this.#play,
      "aria-label",
      running ? t("playback-bar.pause") : ended ? t("playback-bar.play_again") : t("playback-bar.play"),
    );
    for (const button of this.#speeds.querySelectorAll("button")) {
      mark(button, "aria-pressed", String(Number(button.dataset["speed"]) === speed));
    }
    if (performance.now() - this.#movedAt < SETTLE_MS) return;
    const place = progress ?? 0;
    this.#seek.value = String(Math.round(place * STEPS));
    this.#tell(place);
  }

  #draw() {
    this.#drawn = this.#timeline.revision;
    const marks = this.#timeline.marks.map(({ at, kind, words }) => {
      const says = `${duration(at * this.#length)}: ${words}`;
      const mark = make("button.mark", { "data-kind": kind, title: says, "aria-label": says });
      mark.style.setProperty("--at", String(at));
      mark.addEventListener("click", () => void this.session.scrub(at * this.#length));
      return mark;
    });
    this.#marks.replaceChildren(...marks);
  }

  /** @param {number} place 0..1 */
  #tell(place) {
    this.#seek.style.setProperty("--place", `${place * 100}%`);
    const text = t("playback-bar.duration_of_duration2", {
      duration: duration(place * this.#length),
      duration2: duration(this.#length),
    });
    write(this.#time, text);
    mark(this.#seek, "aria-valuetext", text);
  }
}

customElements.define("playback-bar", PlaybackBar);
