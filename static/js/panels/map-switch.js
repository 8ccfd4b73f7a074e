// Element <map-switch>: the choice between the flat map and the 3-D one.

import { make, mark } from "../ui/element.js";
import { chooseMap, mapKind, NO_WEBGL, onMapKind } from "../ui/map-choice.js";
import { Panel } from "../ui/panel.js";
import { t } from "../ui/texts.js";
import { MAP_DRAWN } from "../ui/webgl.js";

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
