// The maps page: the panels of the Maps tab, with room.

import { t } from "../ui/texts.js";
import "../panels/map-card.js";
import "../panels/place-list.js";
import "../panels/route-card.js";
import "../panels/join-card.js";
import "../panels/map-editor.js";
import "../panels/nav2-card.js";
import "../panels/own-navigation-card.js";
import { make } from "../ui/element.js";

export function create() {
  const [saved, places, routes, own] = ["map-card", "place-list", "route-card", "own-navigation-card"].map((name) =>
    document.createElement(name),
  );
  if (own) own.hidden = true;
  const marks = make("section.card.maps-card.maps-marks", { "aria-label": t("main.places_and_routes") });
  marks.append(...[places, routes].filter((part) => part !== undefined));
  const title = make("h2.visually-hidden", t("main.present_map"));
  const [editor, join, nav2] = ["map-editor", "join-card", "nav2-card"].map((name) => document.createElement(name));
  const tools = make("section.card.maps-card", { id: "edit", "aria-label": t("map-editor.edit_the_map") });
  tools.append(...[editor, join, nav2].filter((part) => part !== undefined));
  return { element: make("div.page-cards.maps-page", title, saved, marks, tools, own) };
}
