// Element <first-play>: large Play button of a recording that waits at its beginning.

import { icon, make } from "../ui/element.js";
import { duration } from "../ui/format.js";
import { Panel } from "../ui/panel.js";
import { t } from "../ui/texts.js";

/** @import { View } from "../net/session.js" */

const BEGUN = 0.02; // of the recording; some begin before their first scan

class FirstPlay extends Panel {
  #length = make("span.note");
  #button = make("button.button.primary.first-play", icon("play"), make("span", t("first-play.play_the_recording")));
  #watches = make("p", t("first-play.the_recording_waits_an_operator_can"));
  #played = false;

  /** @override */
  build() {
    this.append(this.#button, this.#watches, this.#length);
    this.#button.addEventListener("click", () => void this.session.playback({ action: "play" }));
    this.session.on("hello", ({ robot }) => (this.#length.textContent = duration(robot.duration_s ?? 0)));
  }

  /** @override @param {View} view */
  show({ state, hello, up }) {
    if (!state || !hello) return;
    const { running, progress } = state.robot;
    this.#played ||= running || (progress ?? 0) > BEGUN;
    this.hidden = !hello.robot.capabilities.includes("replay") || this.#played || !up;
    const watches = hello.you.role === "viewer";
    this.#button.hidden = watches;
    this.#watches.hidden = !watches;
  }
}

customElements.define("first-play", FirstPlay);
