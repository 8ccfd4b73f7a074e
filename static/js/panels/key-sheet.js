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

export class KeySheet extends Sheet {
  /** @override */
  build() {
    this.frame(
      "Keys",
      make(
        "dl",
        { class: "keys" },
        ...KEYS.flatMap(([keys, says]) => [
          make("dt", {}, .../** @type {string[]} */ (keys).map((key) => (key === "…" ? "…" : make("kbd", {}, key)))),
          make("dd", {}, String(says)),
        ]),
      ),
      make("p", { class: "note" }, "Stop is a software stop. It is no emergency stop."),
    );
  }
}

customElements.define("key-sheet", KeySheet);
