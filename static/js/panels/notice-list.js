// Element <notice-list>: notices of the console, newest first; tells its tab how many were not seen yet.

import { icon, isNew, make, mark } from "../ui/element.js";
import { age } from "../ui/format.js";
import { Panel } from "../ui/panel.js";
import { speedsOffer } from "../ui/speeds-offer.js";
import { t } from "../ui/texts.js";

/** @import { NoticeLine } from "../net/messages.js" */
/** @import { View } from "../net/session.js" */

class NoticeList extends Panel {
  #list = make("ol.record-list", { "aria-label": t("notice-list.notices_newest_first") });
  #empty = make("p.record-empty", t("notice-list.nothing_to_report"));
  #seen = -1; // id of the newest notice that was seen

  /** @override */
  build() {
    this.append(this.#list, this.#empty);
  }

  /** @override @param {View} view */
  show({ state }) {
    const notices = state?.notices ?? [];
    if (this.offsetParent !== null) this.#seen = notices.at(-1)?.id ?? -1;
    const unseen = notices.filter(({ id }) => id > this.#seen).length;
    mark(this, "data-unseen", unseen ? String(unseen) : null);
    if (!isNew(this, ...notices.map(({ id, text }) => [id, text]))) return; // a notice can change and end
    this.#list.replaceChildren(...[...notices].reverse().map((one) => row(one, this.session)));
    this.#empty.hidden = notices.length > 0;
  }
}

/** @param {NoticeLine} notice @param {import("../net/session.js").Session} session */
function row(notice, session) {
  const drawing = notice.level === "info" ? "info" : "warning";
  return make(
    "li.record",
    { "data-level": notice.level },
    make("span.outcome-icon", icon(drawing)),
    make(
      "div.record-body",
      make("p", notice.text),
      speedsOffer(session, notice),
      make("p.note", t("notice-list.level_at_age_of_the_robot", { level: notice.level, age: age(notice.stamp_s) })),
    ),
  );
}

customElements.define("notice-list", NoticeList);
