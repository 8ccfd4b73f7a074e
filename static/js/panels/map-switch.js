// Element <map-switch>: the choice between the flat map and the 3-D one.
// Element <swap-button>: lies over the small one of map and camera, or in the corner of the large camera; a press exchanges the two.

import { icon, make, mark } from "../ui/element.js";
import { remember, remembered } from "../ui/local-storage.js";
import { chooseMap, MAP_DRAWN, mapKind, NO_WEBGL, onMapKind } from "../ui/map-choice.js";
import { Panel } from "../ui/panel.js";
import { t } from "../ui/texts.js";

const KINDS = /** @type {const} */ (["flat", "3-D"]);

class MapSwitch extends Panel {
  /** @override */
  build() {
    this.setAttribute("role", "group");
    this.setAttribute("aria-label", t("map-switch.how_the_map_is_drawn"));
    const buttons = KINDS.map((kind) => {
      const absent = kind === "3-D" && !MAP_DRAWN;
      const button = make("button", { disabled: absent }, kind === "flat" ? t("map-switch.flat") : kind);
      if (absent) button.title = NO_WEBGL;
      button.addEventListener("click", () => chooseMap(kind));
      return button;
    });
    this.append(...buttons);
    const show = () => {
      for (const [index, button] of buttons.entries()) mark(button, "aria-pressed", String(KINDS[index] === mapKind()));
    };
    onMapKind(show);
    show();
  }
}

customElements.define("map-switch", MapSwitch);

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
