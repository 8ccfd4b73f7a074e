// The recordings page.

import "../panels/record-button.js";
import "./recordings-list.js";
import { address, wordedPath } from "../net/api.js";
import { icon, make } from "../ui/element.js";
import { t } from "../ui/texts.js";
import { RecordingsModel } from "./recordings-model.js";

/** @param {import("../net/session.js").Session} session */
export function create(session) {
  const model = new RecordingsModel(session);
  const [button, list] = ["record-button", "recordings-list"].map((name) => document.createElement(name));
  const report = make(
    "a.button",
    { href: address(wordedPath("api/reports/drive")).href, download: "", title: t("recordings.report_of_this_drive") },
    icon("download"),
    t("map-card.drive"),
  );
  const help = make("a.link", { href: "help#how-to/record-a-drive.md" }, t("recordings.how_to_record_a_drive"));
  const element = make("section.card.page-card.recordings-page", { "aria-label": t("pages.recordings") });
  element.append(
    make("div.row.recordings-head", button, report, make("span.spring"), help),
    /** @type {Node} */ (list),
  );
  return { element, model, opened: () => model.follow(true), left: () => model.follow(false) };
}
