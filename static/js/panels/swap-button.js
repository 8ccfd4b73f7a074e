// Element <swap-button>: lies over the small one of map and camera, or over the camera; a press exchanges the two.

import { icon, make, mark } from "../ui/element.js";
import { remember, remembered } from "../ui/local-storage.js";
import { Panel } from "../ui/panel.js";
import { t } from "../ui/texts.js";

const CHANGED = "views-swapped";

class SwapButton extends Panel {
  #button = make("button.swap", icon("grow"));

  /** @override */
  build() {
    const place = /** @type {HTMLElement} */ (this.closest("[data-view]"));
    const mine = this.closest("camera-view") ? "camera" : "map";
    const show = () => {
      const says = `${place.dataset["big"] === mine ? t("swap-button.small") : t("swap-button.large")} ${mine}`;
      mark(this.#button, "aria-label", says);
      this.#button.title = says;
    };
    place.dataset["big"] = remembered("big", "map");
    this.#button.addEventListener("click", () => {
      const big = place.dataset["big"] === "camera" ? "map" : "camera";
      place.dataset["big"] = big;
      remember("big", big);
      dispatchEvent(new Event(CHANGED));
    });
    addEventListener(CHANGED, show);
    this.append(this.#button);
    show();
  }
}

customElements.define("swap-button", SwapButton);
