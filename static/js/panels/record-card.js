// Element <record-card>: tabs with history, notices, SLAM figures and maps.

import { onlyWatched } from "../drive/permission.js";
import { qualityRuns, wordsOf } from "../net/api.js";
import { icon, make, mark, write } from "../ui/element.js";
import { age, quantities, timeOfDay } from "../ui/format.js";
import { remember, remembered } from "../ui/local-storage.js";
import { Panel } from "../ui/panel.js";

/** @typedef {import("../net/session.js").View} View */
/** @typedef {import("../net/api.js").HistoryRow} HistoryRow */
/** @typedef {import("../net/messages.js").NoticeLine} NoticeLine */

/** @typedef {"history" | "notices" | "slam" | "maps"} Tab */
const TABS = /** @type {const} */ (["history", "notices", "slam", "maps"]);
const SOURCES = {
  typed: "typed",
  chip: "button",
  click: "map",
  voice: "voice",
  ears: "the robot’s ears",
  rest: "HTTP",
};

class RecordCard extends Panel {
  #history = make("ol", { class: "record-list", tabindex: "0", "aria-label": "History, newest first" });
  #score = make("a", { class: "record-score", href: "hearing", hidden: true });
  #notices = make("ol", { class: "record-list", tabindex: "0", "aria-label": "Notices, newest first", hidden: true });
  #slam = /** @type {HTMLElement} */ (this.querySelector("slam-card"));
  #maps = /** @type {HTMLElement} */ (this.querySelector("map-card"));
  #count = make("span", { class: "count", hidden: true });
  #tabs = {
    history: make("button", { type: "button", class: "tab", "aria-pressed": "true" }, "History"),
    notices: make("button", { type: "button", class: "tab", "aria-pressed": "false" }, "Notices", this.#count),
    slam: make("button", { type: "button", class: "tab", "aria-pressed": "false" }, "SLAM"),
    maps: make("button", { type: "button", class: "tab", "aria-pressed": "false" }, "Maps"),
  };
  #tall = make(
    "button",
    {
      type: "button",
      class: "icon-button small tall-button",
      "aria-label": "In the camera’s place, too",
      title: "In the camera’s place, too",
    },
    icon("grow"),
  );
  /** @type {Tab} */
  #open = "history";
  #empty = make("p", { class: "record-empty" });
  #newestNotice = -1;
  #listedNotices = "";
  #seenNotice = -1;

  /** @override */
  build() {
    this.classList.add("card");
    this.setAttribute("role", "region");
    this.setAttribute("aria-label", "History and notices");
    this.append(
      make(
        "div",
        { class: "card-head tabs" },
        ...Object.values(this.#tabs),
        make("span", { class: "spring" }),
        this.#tall,
      ),
      this.#score,
      this.#history,
      this.#notices,
      this.#slam,
      this.#maps,
      this.#empty,
    );
    for (const tab of TABS) this.#tabs[tab].addEventListener("click", () => this.#turnTo(tab));
    this.session.on("history", (rows) => this.#list(rows));
    this.session.on("hello", () => void this.#readScore());
    document.addEventListener(
      "visibilitychange",
      () => document.visibilityState === "visible" && void this.#readScore(),
    );
    this.session.on("hello", (hello) => {
      this.#tabs.history.hidden = onlyWatched(hello);
      if (onlyWatched(hello) && this.#open === "history") this.#turnTo(innerWidth < 1024 ? "notices" : "slam");
    });
    this.#tall.addEventListener("click", () => {
      remember("tall", this.hasAttribute("data-tall") ? "no" : "yes");
      this.#grow();
    });
    addEventListener("view", (event) => {
      const { detail } = /** @type {CustomEvent<string>} */ (event);
      if (detail === "slam" || (detail === "record" && this.#open === "slam"))
        this.#turnTo(detail === "slam" ? "slam" : this.#tabs.history.hidden ? "notices" : "history");
    });
    this.#turnTo("history");
  }

  /**
   * @override
   * @param {View} view
   */
  show({ state, permission }) {
    for (const button of this.#history.querySelectorAll("button")) button.disabled = permission.may === "no";
    const notices = state?.notices ?? [];
    const newest = notices.at(-1)?.id ?? -1;
    const listed = notices.map(({ id, text }) => `${id} ${text}`).join("|"); // a notice can change and end
    if (listed === this.#listedNotices) return;
    [this.#newestNotice, this.#listedNotices] = [newest, listed];
    if (this.#open === "notices") this.#seenNotice = newest;
    const unseen = notices.filter(({ id }) => id > this.#seenNotice).length;
    this.#count.hidden = unseen === 0;
    write(this.#count, String(unseen));
    this.#notices.replaceChildren(...[...notices].reverse().map(noticeRow));
    this.#explain();
  }

  /** @param {Tab} open */
  #turnTo(open) {
    this.#open = open;
    this.dataset["open"] = open;
    this.#grow();
    const lists = { history: this.#history, notices: this.#notices, slam: this.#slam, maps: this.#maps };
    for (const tab of TABS) {
      lists[tab].hidden = tab !== open;
      this.#score.hidden = open !== "history" || this.#score.textContent === "";
      mark(this.#tabs[tab], "aria-pressed", String(tab === open));
    }
    if (open === "notices") {
      this.#seenNotice = this.#newestNotice;
      this.#count.hidden = true;
    }
    this.#explain();
  }

  /** Show plots and maps in the camera's place, too, unless that was switched off. */
  #grow() {
    const long = this.#open === "slam" || this.#open === "maps";
    const tall = long && remembered("tall", "yes") === "yes";
    mark(this, "data-tall", tall);
    mark(this.#tall, "aria-pressed", String(tall));
    this.#tall.hidden = !long;
  }

  /** Result of the newest speech quality measurement. */
  async #readScore() {
    const runs = await qualityRuns().catch(() => []);
    const newest = runs.find(({ summary }) => summary);
    if (newest) this.#score.replaceChildren(icon("ears"), make("span", {}, `Heard here: ${newest.summary}`));
    this.#score.hidden = this.#open !== "history" || this.#score.textContent === "";
  }

  /** @param {HistoryRow[]} rows newest first */
  #list(rows) {
    this.#history.replaceChildren(...rows.slice(0, 60).map((row) => this.#row(row)));
    this.#explain();
  }

  #explain() {
    const list = this.#open === "history" ? this.#history : this.#notices;
    this.#empty.hidden = this.#open === "slam" || this.#open === "maps" || list.children.length > 0;
    write(this.#empty, list === this.#history ? "Commands and their results appear here." : "Nothing to report.");
  }

  /** @param {HistoryRow} row */
  #row(row) {
    const source = row.source in SOURCES ? SOURCES[/** @type {keyof typeof SOURCES} */ (row.source)] : row.source;
    const words = wordsOf(row);
    const amounts = /\d/.test(words) ? "" : quantities(row.numbers); // "turn left" does not say how far
    const took = row.duration_s !== null && row.state !== "refused" ? age(row.duration_s) : "";
    const again = make(
      "button",
      { type: "button", class: "icon-button small", "aria-label": `Again: ${words}`, title: "Again" },
      icon("again"),
    );
    again.addEventListener("click", () => void this.session.say(words, "chip"));
    return make(
      "li",
      { class: "record", "data-state": row.state },
      make("span", { class: "outcome-icon" }, icon(row.state)),
      make(
        "div",
        { class: "record-body" },
        make(
          "p",
          { class: "record-line" },
          make("span", { class: "record-words" }, words),
          make("span", { class: "outcome" }, row.state),
        ),
        row.remark ? make("p", { class: "record-remark" }, row.remark) : null,
        make(
          "p",
          { class: "note record-meta" },
          timeOfDay(row.at_s),
          dot(),
          icon(row.source in SOURCES ? row.source : "rest"),
          source,
          dot(),
          row.who,
          ...[amounts, took].filter(Boolean).flatMap((text) => [dot(), text]),
        ),
      ),
      again,
    );
  }
}

const dot = () => make("span", { class: "dot", "aria-hidden": "true" }, "·");

/** @param {NoticeLine} notice */
function noticeRow(notice) {
  const drawing = notice.level === "info" ? "info" : "warning";
  return make(
    "li",
    { class: "record", "data-level": notice.level },
    make("span", { class: "outcome-icon" }, icon(drawing)),
    make(
      "div",
      { class: "record-body" },
      make("p", {}, notice.text),
      make("p", { class: "note" }, `${notice.level}, at ${age(notice.stamp_s)} of the robot's clock`),
    ),
  );
}

customElements.define("record-card", RecordCard);
