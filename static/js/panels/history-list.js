// Element <history-list>: the commands that were given, newest first, each with its result.
// Element <notice-list>: notices of the console, newest first; tells its tab how many were not seen yet.

import { onlyWatched } from "../drive/permission.js";
import { qualityRuns, wordsOf } from "../net/api.js";
import { icon, iconButton, isNew, make, mark } from "../ui/element.js";
import { age, quantities, timeOfDay } from "../ui/format.js";
import { couldCall, goesToPerson, letCall } from "../ui/let-call.js";
import { Panel } from "../ui/panel.js";
import { refill } from "../ui/press.js";
import { speedsOffer } from "../ui/speeds-offer.js";
import { t } from "../ui/texts.js";
import { noticedAt } from "../ui/timeline.js";

/** @import { NoticeLine } from "../net/messages.js" */
/** @import { HistoryRow } from "../net/rest.js" */
/** @import { View } from "../net/session.js" */

const [MOST, OFFERED] = [60, 3];
const [THROUGH, MOUTH] = [", through ", "'s mouth"];
const SOURCES = {
  typed: t("history-list.typed"),
  chip: t("history-list.button"),
  click: t("history-list.map"),
  camera: t("history-list.camera_s_picture"),
  voice: t("history-list.voice"),
  ears: t("history-list.the_robot_s_ears"),
  route: t("history-list.route"),
  rest: "HTTP",
};

const TRIES = ["turn left", "continue 1 meter"]; // while there is nothing else

class HistoryList extends Panel {
  /** @type {Map<string, readonly string[]>} by the words of a refused command: what was possibly meant */
  #meant = new Map();
  #list = make("ol.record-list", { "aria-label": t("history-list.history_newest_first") });
  #score = make("a.inline.record-score", { href: "hearing", hidden: true });
  #empty = make(
    "div.record-empty",
    make("p", t("history-list.commands_and_their_results_appear_here")),
    make(
      "p.record-tries",
      ...TRIES.map((words) => make("button.chip", { onclick: () => void this.session.say(words, "chip") }, words)),
    ),
  );

  /** @override */
  build() {
    this.append(this.#score, this.#list, this.#empty);
    this.session.on("said", ({ text, answer }) => this.#remember(text, answer.suggestions ?? []));
    this.session.on("transcript", ({ words, suggestions }) => this.#remember(words, suggestions));
    this.session.on("history", (rows) => this.#draw(rows));
    this.session.on("hello", (hello) => {
      this.hidden = onlyWatched(hello);
      void this.#readScore();
    });
    document.addEventListener(
      "visibilitychange",
      () => document.visibilityState === "visible" && void this.#readScore(),
    );
  }

  /** @override @param {View} view */
  show({ permission }) {
    for (const button of this.querySelectorAll("button")) button.disabled = permission.may === "no";
  }

  async #readScore() {
    const runs = await qualityRuns().catch(() => []);
    const newest = runs.find(({ summary }) => summary);
    if (newest)
      this.#score.replaceChildren(
        icon("ears"),
        make("span", t("history-list.heard_here_summary", { summary: newest.summary })),
      );
    this.#score.hidden = !newest;
  }

  /** @param {string} words @param {readonly string[]} suggestions */
  #remember(words, suggestions) {
    if (suggestions.length === 0) return;
    this.#meant.delete(words);
    this.#meant.set(words, suggestions.slice(0, OFFERED));
    const [oldest] = this.#meant.keys();
    if (this.#meant.size > MOST && oldest !== undefined) this.#meant.delete(oldest);
    this.#draw(this.session.history);
  }

  /** @param {HistoryRow[]} rows newest first */
  #draw(rows) {
    refill(this.#list, ...rows.slice(0, MOST).map((row, index) => this.#row(row, index === 0)));
    this.#empty.hidden = rows.length > 0;
  }

  /** @param {HistoryRow} row @param {boolean} newest */
  #row(row, newest) {
    const source = row.source in SOURCES ? SOURCES[/** @type {keyof typeof SOURCES} */ (row.source)] : row.source;
    const words = wordsOf(row);
    const amounts = /\d/.test(words) ? "" : quantities(row.numbers); // "turn left" does not say how far
    const took = row.duration_s !== null && row.state !== "refused" ? age(row.duration_s) : "";
    const more = { title: t("history-list.again"), look: "small" };
    const say = () => void this.session.say(words, "chip");
    const again = iconButton("again", t("history-list.again_words", { words }), say, more);
    return make(
      "li.record",
      { "data-state": row.state },
      make("span.outcome-icon", icon(row.state)),
      make(
        "div.record-body",
        make("p.record-line", make("span.record-words", words), make("span.outcome", t(`state.${row.state}`))),
        row.remark ? make("p.record-remark", row.remark) : null,
        row.state === "refused" ? this.#offers(words, newest) : null,
        make(
          "p.note.row.record-meta",
          make("span", timeOfDay(row.at_s)),
          make("span", icon(row.source === "route" ? "pin" : row.source in SOURCES ? row.source : "rest"), source),
          make("span", this.#who(row.who)),
          amounts ? make("span", amounts) : null,
          took ? make("span", took) : null,
        ),
      ),
      again,
    );
  }

  /** @param {string} who as the console names them: "operator 1, through Ann's mouth" @returns {string} */
  #who(who) {
    const [person, mouth] = who.split(THROUGH);
    if (mouth === undefined || person !== this.session.hello?.you.name) return who;
    return t("history-list.you_through", { mouth: mouth.slice(0, -MOUTH.length) });
  }

  /** @param {string} words of a refused command @param {boolean} newest */
  #offers(words, newest) {
    const chips = (this.#meant.get(words) ?? []).map((text) =>
      make("button.chip", { onclick: () => void this.session.say(text, "chip") }, text),
    );
    if (newest && couldCall() && goesToPerson(this.session, words)) chips.push(letCall(couldCall(), words));
    if (chips.length === 0) return null;
    return make("div.row.suggested", { role: "group", "aria-label": t("command-status.did_you_mean") }, ...chips);
  }
}

customElements.define("history-list", HistoryList);

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
    if (!isNew(this, ...notices.map(({ id, text, at_s: at }) => [id, text, at]))) return; // a notice can change and end
    const newest = [...notices].reverse();
    this.#list.replaceChildren(...newest.map((one) => row(one, this.session, noticedAt(one, this.session))));
    this.#empty.hidden = notices.length > 0;
  }
}

const LEVELS = { info: t("notice-list.note"), warning: t("notice-list.warning"), error: t("notice-list.error") };

/** @param {NoticeLine} notice @param {import("../net/session.js").Session} session @param {string} at when it came */
function row(notice, session, at) {
  const drawing = notice.level === "info" ? "info" : "warning";
  return make(
    "li.record",
    { "data-level": notice.level },
    make("span.outcome-icon", icon(drawing)),
    make(
      "div.record-body",
      make("p", notice.text),
      speedsOffer(session, notice),
      make("p.note", `${LEVELS[notice.level]} · ${at}`),
    ),
  );
}

customElements.define("notice-list", NoticeList);
