// The maps page: the panels of the Maps tab, with room.

import { t } from "../ui/texts.js";
import "../panels/map-card.js";
import "../panels/place-list.js";
import "../panels/own-navigation-card.js";
import { make } from "../ui/element.js";

export function create() {
  const [saved, places, own] = ["map-card", "place-list", "own-navigation-card"].map((name) =>
    document.createElement(name),
  );
  if (own) own.hidden = true;
  const title = make("h2", {}, t("main.present_map"));
  const card = make("section", { class: "card maps-card", "aria-label": t("main.maps") }, title);
  if (places) card.append(places);
  if (saved) card.append(saved);
  return { element: make("div", { class: "maps-page" }, card, own) };
}
