// The maps page: the panels of the Maps tab, with room.

import { t } from "../ui/texts.js";
import "../panels/map-card.js";
import "../panels/place-list.js";
import "../panels/route-card.js";
import "../panels/own-navigation-card.js";
import { make } from "../ui/element.js";

export function create() {
  const [saved, places, routes, own] = ["map-card", "place-list", "route-card", "own-navigation-card"].map((name) =>
    document.createElement(name),
  );
  if (own) own.hidden = true;
  const marks = make("section", { class: "card maps-card maps-marks", "aria-label": t("main.places_and_routes") });
  marks.append(...[places, routes].filter((part) => part !== undefined));
  const title = make("h2", { class: "visually-hidden" }, t("main.present_map"));
  return { element: make("div", { class: "maps-page" }, title, saved, marks, own) };
}
