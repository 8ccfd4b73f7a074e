// Element <key-sheet>: dialog that lists the keys of the page.

import { icon, make } from "../ui/element.js";
import { Panel } from "../ui/panel.js";

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

export class KeySheet extends Panel {
  #close = make("button", { type: "button", class: "icon-button", "aria-label": "Close" }, icon("close"));
  /** @type {HTMLElement | null} */
  #cameFrom = null;

  /** @override */
  build() {
    this.setAttribute("role", "dialog");
    this.setAttribute("aria-label", "Keys");
    this.append(
      make(
        "div",
        { class: "card sheet" },
        make(
          "div",
          { class: "card-head" },
          make("h2", { class: "card-title" }, "Keys"),
          make("span", { class: "spring" }),
          this.#close,
        ),
        make(
          "dl",
          { class: "keys" },
          ...KEYS.flatMap(([keys, says]) => [
            make("dt", {}, .../** @type {string[]} */ (keys).map((key) => (key === "…" ? "…" : make("kbd", {}, key)))),
            make("dd", {}, String(says)),
          ]),
        ),
        make("p", { class: "note" }, "Stop is a software stop. It is no emergency stop."),
      ),
    );
    this.#close.addEventListener("click", () => this.shut());
    this.addEventListener("click", (event) => event.target === this && this.shut());
    addEventListener("keydown", (event) => event.key === "Escape" && this.shut());
  }

  toggle() {
    if (!this.hasAttribute("hidden")) {
      this.shut();
      return;
    }
    this.#cameFrom = document.activeElement instanceof HTMLElement ? document.activeElement : null;
    this.hidden = false;
    this.#close.focus();
  }

  shut() {
    if (this.hidden) return;
    this.hidden = true;
    this.#cameFrom?.focus();
  }
}

customElements.define("key-sheet", KeySheet);
