// Element <app-menu>: halt, keys, hints, HTTP interface, sign-out.

import { icon, make, mark } from "../ui/element.js";
import { remember, remembered } from "../ui/local-storage.js";
import { Panel } from "../ui/panel.js";
import { popover } from "../ui/popover.js";

/** @typedef {import("../net/session.js").View} View */

class AppMenu extends Panel {
  #button = make("button", { type: "button", class: "icon-button", "aria-label": "Menu", title: "Menu" }, icon("menu"));
  #halt = item("halt", "Halt", "Stops the robot and keeps it stopped, also over a restart, until it is reset.");
  #reset = item("undo", "Reset the halt", "The reset itself does not move the robot.");
  #keys = item("keys", "Keys", "Every key of this page.");
  #gamepad = item("gamepad", "Gamepad", "Its buttons and sticks, and what each does.");
  #signIns = item("qr", "Phones and sign-ins", "A link for a phone or another person; who is signed in.");
  #tour = item("play", "Tour", "Ninety seconds in the simulator; any key ends it.");
  #settings = item("settings", "Settings", "Speeds, distances, voice, recognizer; which need a restart.");
  #hints = item("hints", "Show the first hints again", "");
  #single = make("input", { type: "checkbox", class: "switch", role: "switch" });
  #switch = make(
    "label",
    { class: "menu-item" },
    icon("typed"),
    make(
      "span",
      { class: "menu-words" },
      make("span", {}, "Single-key shortcuts"),
      make("span", { class: "note" }, "W A S D, Space, digits and /. Esc always stops."),
    ),
    this.#single,
  );
  #docs = make(
    "a",
    { class: "menu-item", href: "docs", target: "_blank", rel: "noopener" },
    icon("book"),
    make("span", { class: "menu-words" }, "HTTP interface"),
  );
  #leave = item("leave", "Sign out", "");
  #panel = make(
    "div",
    { class: "menu", role: "group", "aria-label": "Menu" },
    this.#halt,
    this.#reset,
    this.#keys,
    this.#gamepad,
    this.#signIns,
    this.#tour,
    this.#settings,
    this.#hints,
    this.#switch,
    this.#docs,
    this.#leave,
  );

  /** @override */
  build() {
    this.append(this.#button, this.#panel);
    mark(this.#halt, "data-tone", "fault");
    const { close } = popover(this.#button, this.#panel);
    this.#single.checked = remembered("single-keys", "on") === "on";
    this.#single.addEventListener("keydown", (event) => event.key === "Enter" && this.#single.click()); // Space stops
    this.#single.addEventListener("change", () => {
      remember("single-keys", this.#single.checked ? "on" : "off");
      this.dispatchEvent(new CustomEvent("single-keys", { detail: this.#single.checked, bubbles: true }));
    });
    /** @param {HTMLElement} row @param {() => void} act */
    const on = (row, act) =>
      row.addEventListener("click", () => {
        close();
        act();
      });
    on(this.#halt, () => this.session.halt());
    on(this.#reset, () => void this.session.resetHalt());
    on(this.#keys, () => this.dispatchEvent(new CustomEvent("show-keys", { bubbles: true })));
    on(this.#gamepad, () => this.dispatchEvent(new CustomEvent("show-gamepad", { bubbles: true })));
    on(this.#signIns, () => this.dispatchEvent(new CustomEvent("show-sign-ins", { bubbles: true })));
    on(this.#tour, () => dispatchEvent(new CustomEvent("show-tour")));
    on(this.#settings, () => this.dispatchEvent(new CustomEvent("show-settings", { bubbles: true })));
    on(this.#hints, () => this.dispatchEvent(new CustomEvent("show-hints", { bubbles: true })));
    on(this.#leave, () => void this.session.leave());
  }

  /**
   * @override
   * @param {View} view
   */
  show({ hello, state, up }) {
    const drives = hello?.robot.drives === true;
    this.#halt.hidden = !drives; // a row never changes under a finger, and a halt may always be tried
    this.#reset.hidden = !drives || hello?.you.role === "viewer";
    this.#reset.disabled = !up || state?.gate.state !== "halted";
    this.#hints.hidden = !drives || hello?.you.role === "viewer";
    this.#tour.hidden = this.#hints.hidden || !hello?.robot.capabilities.includes("simulate");
    this.#switch.hidden = this.#gamepad.hidden = !drives;
    this.#signIns.hidden = hello?.you.role === "viewer" || hello?.you.id === "local";
    this.#leave.hidden = hello?.you.id === "local"; // no sign-in on this machine
  }
}

/**
 * @param {string} drawing
 * @param {string} name
 * @param {string} says
 */
function item(drawing, name, says) {
  const words = make(
    "span",
    { class: "menu-words" },
    make("span", { class: "menu-name" }, name),
    says && make("span", { class: "note" }, says),
  );
  return make("button", { type: "button", class: "menu-item" }, icon(drawing), words);
}

customElements.define("app-menu", AppMenu);
