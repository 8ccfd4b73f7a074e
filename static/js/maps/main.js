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
  const title = make("h2", {}, t("main.present_map"));
  const card = make("section", { class: "card maps-card", "aria-label": t("main.maps") }, title);
  if (places) card.append(places);
  if (routes) card.append(routes);
  if (saved) card.append(saved);
  return { element: make("div", { class: "maps-page" }, card, own) };
}
