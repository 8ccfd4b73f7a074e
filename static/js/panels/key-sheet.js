// Element <key-sheet>: dialog that lists the keys of the page.

import { make } from "../ui/element.js";
import { Sheet } from "../ui/sheet.js";

const KEYS = [
  [["Esc"], "Stop, everywhere, also while typing"],
  [["Space"], "Stop, outside text boxes"],
  [["W", "A", "S", "D"], "Hold to drive; the arrow keys too"],
  [["Shift"], "Slow, while driving"],
  [["1", "…", "5"], "Speed"],
  [["V"], "Hold to talk"],
  [["/"], "To the command line"],
  [["↑", "↓"], "In the command line: earlier commands, or the suggestions"],
  [["Enter"], "Send; press the button in focus; begin the pending command"],
  [["?"], "This sheet"],
];

const RECORDING_KEYS = [
  [["Space"], "Play and pause"],
  [["←", "→"], "Five seconds back or on"],
  [["Esc"], "Pause, also while typing"],
  [["?"], "This sheet"],
];

/** @param {typeof KEYS} list */
const rows = (list) =>
  list.flatMap(([keys, says]) => [
    make("dt", {}, .../** @type {string[]} */ (keys).map((key) => (key === "…" ? "…" : make("kbd", {}, key)))),
    make("dd", {}, String(says)),
  ]);

export class KeySheet extends Sheet {
  #list = make("dl", { class: "keys" }, ...rows(KEYS));

  /** @override */
  build() {
    this.frame("Keys", this.#list, make("p", { class: "note" }, "Stop is a software stop. It is no emergency stop."));
    this.session.on("hello", ({ robot }) => {
      const recording = robot.capabilities.includes("replay") && !robot.dry_run;
      this.#list.replaceChildren(...rows(recording ? RECORDING_KEYS : KEYS));
    });
  }
}

customElements.define("key-sheet", KeySheet);
