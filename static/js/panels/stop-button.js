// Element <stop-button>: STOP, always in the same place and on top. Acts on pointer down, not on release.
// A recording has nothing to stop: there the button pauses it, and ends a dry run that is shown.

import { icon, make, mark, redraw, write } from "../ui/element.js";
import { Panel } from "../ui/panel.js";
import { t } from "../ui/texts.js";

/** @import { View } from "../net/session.js" */

const SHOWN_MS = 700;
const ANSWERED_MS = 3000;
const MAX_ANSWER_MS = 10_000; // a later answer says how long the link was lost, not how quickly the robot was stopped
const MOVING = 0.01; // [m/s], [rad/s]
const TOUCH_MS = 600; // the click that follows a touch is the same press

const STOPS = t("stop-button.stops_the_robot_and_cancels_what");
const PAUSES = t("stop-button.pauses_the_recording_nothing_moves_here");
const UNLINKED = t("stop-button.no_link_stop_may_not_arrive");

class StopButton extends Panel {
  #icon = icon("stop");
  #word = make("span.stop-word", t("stop-button.stop"));
  #note = make("span.stop-note");
  #button = make(
    "button.stop",
    { "aria-keyshortcuts": "Escape Space", title: STOPS },
    this.#icon,
    make("span.stop-words", this.#word, this.#note),
    make("kbd", { "aria-hidden": "true" }, "Esc"),
  );
  #touchedAt = -Infinity;
  #timer = 0;
  #answered = ""; // how quickly the newest press was answered
  #answers = 0; // timer

  /** @override */
  build() {
    this.append(this.#button);
    this.#button.addEventListener("pointerdown", () => {
      this.#touchedAt = performance.now();
      this.session.stop();
    });
    this.#button.addEventListener("click", () => {
      if (performance.now() - this.#touchedAt > TOUCH_MS) this.session.stop();
    });
    this.session.on("stop-answered", (ms) => {
      this.#answered = ms < MAX_ANSWER_MS ? t("stop-button.answered_in_ms_ms", { ms }) : "";
      clearTimeout(this.#answers);
      this.#answers = setTimeout(() => (this.#answered = ""), ANSWERED_MS);
    });
    this.session.on("stopped", () => {
      this.#button.classList.add("is-sent");
      clearTimeout(this.#timer);
      this.#timer = setTimeout(() => this.#button.classList.remove("is-sent"), SHOWN_MS);
    });
  }

  /** @override @param {View} view */
  show({ hello, state, up }) {
    const tried = state?.command && state.playback?.way !== "recorded"; // here and now, and shown only
    const recording = hello?.robot.capabilities.includes("replay") === true && !tried;
    const lost = !up && state !== null && !recording;
    mark(this.#button, "data-recording", recording);
    mark(this.#button, "data-unlinked", lost);
    mark(this.#button, "data-still", up && !recording && state !== null && standsStill(state));
    mark(this.#button, "aria-label", recording ? t("stop-button.pause_the_recording") : null);
    mark(this.#button, "title", recording ? PAUSES : lost ? UNLINKED : STOPS);
    this.#button.disabled = recording && (hello.you.role === "viewer" || !up || state?.robot.running !== true);
    redraw(this.#icon, recording ? "pause" : "stop");
    write(this.#word, recording ? t("stop-button.pause") : t("stop-button.stop"));
    write(this.#note, lost ? t("stop-button.no_link") : this.#answered);
  }
}

/** True where nobody and nothing could move the robot. @param {import("../net/messages.js").State} state */
function standsStill({ lease, command, velocity }) {
  const moves = Math.abs(velocity.v_m_s) > MOVING || Math.abs(velocity.w_rad_s) > MOVING;
  return lease.holder === null && command === null && !moves;
}

customElements.define("stop-button", StopButton);
