// What must not be missed, over the map.

import { banners } from "../banners.js";
import { icon, make, write } from "../element.js";
import { Panel } from "../panel.js";

/** @typedef {import("../session.js").View} View */
/** @typedef {import("../banners.js").Banner} Banner */

class BannerStack extends Panel {
  /** @type {Map<string, HTMLElement>} */
  #shown = new Map();

  /**
   * @override
   * @param {View} view
   */
  show(view) {
    const told = banners(view);
    for (const [id, row] of this.#shown) {
      if (told.some((banner) => key(banner) === id)) continue;
      row.remove();
      this.#shown.delete(id);
    }
    for (const banner of told) {
      const row = this.#shown.get(key(banner)) ?? this.#raise(banner);
      write(/** @type {Element} */ (row.querySelector(".banner-text")), banner.text);
    }
  }

  /** @param {Banner} banner */
  #raise(banner) {
    const reset = banner.offers === "reset" && make("button", { type: "button", class: "button" }, "Reset the halt");
    if (reset) reset.addEventListener("click", () => void this.session.resetHalt());
    const row = make(
      "div",
      { class: "banner", "data-tone": banner.tone, "data-banner": banner.id },
      icon(banner.icon),
      make("p", { class: "banner-text" }),
      reset,
    );
    this.#shown.set(key(banner), row);
    this.append(row);
    this.session.announce(banner.text);
    return row;
  }
}

/** @param {Banner} banner */
const key = (banner) => `${banner.id} ${banner.tone} ${banner.offers}`;

customElements.define("banner-stack", BannerStack);
