// Element <view-tabs>: on a narrow screen, selects the view above the driving controls; a swipe moves on.

import { onlyWatched } from "../drive/permission.js";
import { icon, make, mark, write } from "../ui/element.js";
import { Panel } from "../ui/panel.js";

/** @typedef {import("../net/session.js").View} View */

const VIEWS = /** @type {const} */ ([
  ["map", "Map"],
  ["camera", "Camera"],
  ["estimate", "Estimate"],
  ["ears", "Ears"],
  ["slam", "SLAM"],
  ["record", "History"],
]);
const SWIPE_PX = 48;

class ViewTabs extends Panel {
  #place = /** @type {HTMLElement} */ (this.closest("[data-view]"));
  #startX = 0;
  #startY = 0;

  /** @override */
  build() {
    this.append(
      make(
        "div",
        { class: "view-tabs", role: "group", "aria-label": "Views" },
        ...VIEWS.map(([view, name]) => {
          const button = make(
            "button",
            { type: "button", class: "view-tab", "data-to": view },
            icon(view),
            make("span", {}, name),
          );
          button.addEventListener("click", () => this.open(view));
          return button;
        }),
      ),
    );
    this.open("map");
    addEventListener("open-view", (event) => this.open(/** @type {CustomEvent<string>} */ (event).detail));
    for (const swiped of [this, ...this.#place.querySelectorAll(".side > *")]) {
      swiped.addEventListener("touchstart", (event) => this.#begin(/** @type {TouchEvent} */ (event)), {
        passive: true,
      });
      swiped.addEventListener("touchend", (event) => this.#end(/** @type {TouchEvent} */ (event)), { passive: true });
    }
  }

  /**
   * Hide tabs without content: a recording may lack pictures and has no commands, a robot may lack microphones.
   * @override
   * @param {View} view
   */
  show({ hello }) {
    const blind = this.#place.querySelector("camera-view")?.hasAttribute("hidden") === true;
    const deaf = this.#place.querySelector("hearing-card")?.hasAttribute("hidden") === true;
    if (deaf && this.#place.dataset["view"] === "ears") this.open("map");
    if (blind && this.#place.dataset["view"] === "camera") this.open("map");
    for (const button of this.querySelectorAll("button")) {
      if (button.dataset["to"] === "camera") button.hidden = blind;
      if (button.dataset["to"] === "ears") button.hidden = deaf;
      const words = button.lastElementChild;
      if (button.dataset["to"] === "record" && words) write(words, onlyWatched(hello) ? "Notices" : "History");
    }
  }

  /** @param {string} view */
  open(view) {
    this.#place.dataset["view"] = view;
    for (const button of this.querySelectorAll("button"))
      mark(button, "aria-pressed", String(button.dataset["to"] === view));
    this.dispatchEvent(new CustomEvent("view", { detail: view, bubbles: true }));
  }

  /** @param {TouchEvent} event */
  #begin(event) {
    const touch = event.changedTouches[0];
    [this.#startX, this.#startY] = [touch?.clientX ?? 0, touch?.clientY ?? 0];
  }

  /** @param {TouchEvent} event */
  #end(event) {
    const touch = event.changedTouches[0];
    const across = (touch?.clientX ?? this.#startX) - this.#startX;
    const down = (touch?.clientY ?? this.#startY) - this.#startY;
    if (Math.abs(across) < SWIPE_PX || Math.abs(across) < 2 * Math.abs(down)) return;
    const shown = [...this.querySelectorAll("button")].filter((button) => !button.hidden);
    const present = shown.findIndex((button) => button.dataset["to"] === this.#place.dataset["view"]);
    shown[present + (across < 0 ? 1 : -1)]?.click();
  }
}

customElements.define("view-tabs", ViewTabs);
