// Start of the fleet's page: its session, its elements, and sign-in by a printed link.

import "../panels/theme-toggle.js";
import "../ui/theme.js";
import "./fleet-bar.js";
import "./fleet-cards.js";
import "./fleet-maps.js";
import { enterByLink } from "../panels/login-view.js";
import { Panel } from "../ui/panel.js";
import { writeTexts } from "../ui/texts.js";
import { FleetSession } from "./fleet-session.js";

writeTexts(document);
const session = new FleetSession();

/** @template {HTMLElement} T @param {string} tag @returns {T} */
const part = (tag) => /** @type {T} */ (document.querySelector(tag));

for (const tag of ["login-view", "theme-toggle"]) {
  const panel = part(tag);
  if (panel instanceof Panel) panel.join(/** @type {any} */ (session));
}
const cards = /** @type {import("./fleet-cards.js").FleetCards} */ (part("fleet-cards"));
cards.join(session);
/** @type {import("./fleet-bar.js").FleetCounts} */ (part("fleet-counts")).join(session, (group, words) =>
  cards.filter(group, words),
);
/** @type {import("./fleet-bar.js").FleetStop} */ (part("fleet-stop")).join(session);
/** @type {import("./fleet-bar.js").FleetBanner} */ (part("fleet-banner")).join(session);
/** @type {import("./fleet-maps.js").FleetMaps} */ (part("fleet-maps")).join(session);
/** @type {import("./fleet-bar.js").FleetAnswers} */ (part("fleet-answers")).join(session);

addEventListener("hashchange", enterByLink);
if (!enterByLink()) void session.begin();
