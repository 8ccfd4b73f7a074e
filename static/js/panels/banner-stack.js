// Element <banner-stack>: banners over the map.

import * as maps from "../net/maps-api.js";
import { banners } from "../ui/banners.js";
import { icon, make, write } from "../ui/element.js";
import { Panel } from "../ui/panel.js";
import { t } from "../ui/texts.js";

/** @import { Session, View } from "../net/session.js" */
/** @import { Banner } from "../ui/banners.js" */

/** @type {Record<Banner["offers"], Array<[string, (session: Session, from: HTMLElement) => void]>>} */
const OFFERS = {
  "": [],
  reset: [[t("banner-stack.reset_the_halt"), (session) => void session.resetHalt()]],
  here: [
    [
      t("banner-stack.show_where_it_is"),
      (_, from) => from.dispatchEvent(new CustomEvent("place-robot", { bubbles: true })),
    ],
  ],
  answer: [
    [t("banner-stack.give_control"), (session) => void session.lease("give")],
    [t("banner-stack.keep_it"), (session) => void session.lease("keep")],
  ],
  seen: [[t("banner-stack.dismiss"), (session) => session.dismissLostControl()]],
  begun: [[t("banner-stack.dismiss"), (session) => session.dismissRestart()]],
  load: [
    [t("banner-stack.load_the_last_map"), (session) => void loadLast(session)],
    [t("banner-stack.dismiss"), (session) => session.dismissRestart()],
  ],
  regain: [
    [
      t("banner-stack.ask_for_control"),
      (session) => void session.lease("ask").then(({ ok }) => ok && session.dismissLostControl()),
    ],
    [t("banner-stack.dismiss"), (session) => session.dismissLostControl()],
  ],
};

/** Go on in the map that was saved last. @param {Session} session */
async function loadLast(session) {
  const done = await session.attempt(async () => {
    const [last] = await maps.list();
    if (!last) throw new Error(t("banner-stack.no_map_is_saved"));
    await maps.load(last.name);
  });
  if (done) session.dismissRestart();
}

class BannerStack extends Panel {
  /** @type {Map<string, HTMLElement>} */
  #shown = new Map();

  /** @override @param {View} view */
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
    const offers = OFFERS[banner.offers].map(([words, act]) =>
      make("button.button", { onclick: () => act(this.session, this) }, words),
    );
    const row = make(
      "div.banner",
      { "data-tone": banner.tone, "data-banner": banner.id },
      icon(banner.icon),
      make("p.banner-text"),
      ...offers,
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
