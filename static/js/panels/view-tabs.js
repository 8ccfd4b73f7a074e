// Element <view-tabs>: on a narrow screen, selects the view above the driving controls; a swipe moves on.

import { icon, make, mark } from "../ui/element.js";
import { Panel } from "../ui/panel.js";
import { t } from "../ui/texts.js";

const VIEWS = /** @type {const} */ ([
  ["map", t("view-tabs.map")],
  ["camera", t("view-tabs.camera")],
  ["details", t("view-tabs.details")],
]);
const ICONS = { map: "map", camera: "camera", details: "record" };
const SWIPE_PX = 48;

class ViewTabs extends Panel {
  #place = /** @type {HTMLElement} */ (this.closest("[data-view]"));
  #startX = 0;
  #startY = 0;

  /** @override */
  build() {
    this.append(
      make(
        "div.view-tabs",
        { role: "group", "aria-label": t("view-tabs.views") },
        ...VIEWS.map(([view, name]) =>
          make(
            "button.view-tab",
            { "data-to": view, onclick: () => this.open(view) },
            icon(ICONS[view]),
            make("span", name),
          ),
        ),
      ),
    );
    this.open("map");
    addEventListener("open-view", (event) => {
      const { detail } = /** @type {CustomEvent<string>} */ (event);
      this.open(VIEWS.some(([view]) => view === detail) ? detail : "details"); // any other name is that of a tab
    });
    for (const swiped of [this, ...this.#place.querySelectorAll("camera-view, tab-card")]) {
      swiped.addEventListener("touchstart", (event) => this.#begin(/** @type {TouchEvent} */ (event)), {
        passive: true,
      });
      swiped.addEventListener("touchend", (event) => this.#end(/** @type {TouchEvent} */ (event)), { passive: true });
    }
  }

  /** A recording may lack pictures. @override */
  show() {
    const blind = this.#place.querySelector("camera-view")?.hasAttribute("hidden") === true;
    if (blind && this.#place.dataset["view"] === "camera") this.open("map");
    for (const button of this.querySelectorAll("button")) if (button.dataset["to"] === "camera") button.hidden = blind;
  }

  /** @param {string} view */
  open(view) {
    this.#place.dataset["view"] = view;
    for (const button of this.querySelectorAll("button"))
      mark(button, "aria-pressed", String(button.dataset["to"] === view));
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
