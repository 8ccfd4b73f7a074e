// Element <banner-stack>: banners over the map.

import { banners } from "../ui/banners.js";
import { icon, make, write } from "../ui/element.js";
import { Panel } from "../ui/panel.js";

/** @typedef {import("../net/session.js").View} View */
/** @typedef {import("../ui/banners.js").Banner} Banner */

const OFFERS = { "": "", reset: "Reset the halt", here: "Show where it is" };

class BannerStack extends Panel {
  /** @type {Map<string, HTMLElement>} */
  #shown = new Map();

  /**
   * @override
   * @param {View} view
   */
  show(view) {
    const current = banners(view);
    for (const [id, row] of this.#shown) {
      if (current.some((banner) => key(banner) === id)) continue;
      row.remove();
      this.#shown.delete(id);
    }
    for (const banner of current) {
      const row = this.#shown.get(key(banner)) ?? this.#raise(banner);
      write(/** @type {Element} */ (row.querySelector(".banner-text")), banner.text);
    }
  }

  /** @param {Banner} banner */
  #raise(banner) {
    const words = OFFERS[banner.offers];
    const offer = words && make("button", { type: "button", class: "button" }, words);
    if (offer) offer.addEventListener("click", () => this.#take(banner.offers));
    const row = make(
      "div",
      { class: "banner", "data-tone": banner.tone, "data-banner": banner.id },
      icon(banner.icon),
      make("p", { class: "banner-text" }),
      offer,
    );
    this.#shown.set(key(banner), row);
    this.append(row);
    this.session.announce(banner.text);
    return row;
  }

  /** @param {Banner["offers"]} offer */
  #take(offer) {
    if (offer === "reset") void this.session.resetHalt();
    else this.dispatchEvent(new CustomEvent("place-robot", { bubbles: true }));
  }
}

/** @param {Banner} banner */
const key = (banner) => `${banner.id} ${banner.tone} ${banner.offers}`;

customElements.define("banner-stack", BannerStack);
