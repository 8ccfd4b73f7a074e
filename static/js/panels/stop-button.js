// STOP: always in the same place and over everything. It acts when it is touched, not when it is let go.

import { icon, make } from "../element.js";
import { Panel } from "../panel.js";

const SHOWN_MS = 700;
const TOUCH_MS = 600; // the click that follows a touch is the same press

class StopButton extends Panel {
  #button = make(
    "button",
    {
      type: "button",
      class: "stop",
      "aria-keyshortcuts": "Escape Space",
      title: "Stops the robot and cancels what it was doing. A software stop: it is no emergency stop.",
    },
    icon("stop"),
    make("span", { class: "stop-word" }, "STOP"),
    make("kbd", { "aria-hidden": "true" }, "Esc"),
  );
  #touchedAt = -Infinity;
  #timer = 0;

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
    this.session.on("stopped", () => {
      this.#button.classList.add("is-sent");
      clearTimeout(this.#timer);
      this.#timer = setTimeout(() => this.#button.classList.remove("is-sent"), SHOWN_MS);
    });
  }
}

customElements.define("stop-button", StopButton);
