// Element <slam-card>: SLAM figures over the last two minutes, rooms, closures and landmarks.
// Element <landmark-table>: landmarks with position, uncertainty, hits and misses (the paper’s table L).
// Element <closure-list>: loop closures with their rooms and scores, and buttons to undo or redo them.

import * as maps from "../net/maps-api.js";
import { icon, make, mark, redraw, write } from "../ui/element.js";
import { age, fixed, largestSigma } from "../ui/format.js";
import { Panel } from "../ui/panel.js";
import { inLanguage, t } from "../ui/texts.js";
import { LivePlot } from "./live-plot.js";

/** @import { LandmarkRow, ClosureRow, SubmapsState as FloorState } from "../net/messages.js" */
/** @import { View, Session } from "../net/session.js" */
/** @typedef {{row: HTMLLIElement, rooms: Element, words: Element, button: HTMLButtonElement}} Line */

const STATES = {
  accepted: t("closure-list.holds"),
  undone: t("closure-list.undone"),
  doubtful: t("closure-list.doubtful"),
};

export class ClosureList extends HTMLElement {
  #list = make("ol.closures", { "aria-label": t("closure-list.closures_newest_first") });
  #count = make("span.note");
  #empty = make("p.note.closures-empty", t("closure-list.none_yet_a_closure_corrects_the"));
  #all = make("button.button.wide", {
    hidden: true,
    onclick: () => void this.#session?.attempt(async () => (this.#older = await maps.closures())),
  });
  /** @type {Map<number, Line>} */
  #lines = new Map();
  /** @type {Session | null} */
  #session = null;
  /** @type {ClosureRow[]} older than those in the state message */
  #older = [];

  /** @param {Session} session */
  join(session) {
    this.#session = session;
    this.append(
      make("div.inline.slam-head", make("h3", t("closure-list.closures")), make("span.spring"), this.#count),
      this.#empty,
      this.#list,
      this.#all,
    );
  }

  /**
   * @param {FloorState} floor
   * @param {number} now [s], robot clock
   * @param {boolean} may true when this user may undo and redo
   */
  show({ closures, closures_count: count }, now, may) {
    if (this.offsetParent === null) return;
    const newest = new Set(closures.map(({ id }) => id));
    const rows = [...this.#older.filter(({ id }) => !newest.has(id)), ...closures].slice(-count || closures.length);
    const accepted = closures.filter(({ state }) => state === "accepted").length;
    write(
      this.#count,
      count > closures.length ? `${count}` : count ? t("closure-list.accepted_of_count_hold", { accepted, count }) : "",
    );
    this.#empty.hidden = count > 0;
    this.#all.hidden = rows.length >= count;
    write(this.#all, t("closure-list.show_count_older", { count: count - rows.length }));
    for (const [id, { row }] of this.#lines) {
      if (rows.some((closure) => closure.id === id)) continue;
      row.remove();
      this.#lines.delete(id);
    }
    for (const closure of rows) this.#fill(this.#lines.get(closure.id) ?? this.#add(closure), closure, now, may);
  }

  /**
   * @param {Line} line
   * @param {ClosureRow} closure
   * @param {number} now
   * @param {boolean} may
   */
  #fill({ row, rooms, words, button }, closure, now, may) {
    const undone = closure.state === "undone";
    mark(row, "data-state", closure.state);
    write(
      rooms,
      closure.submap_from === closure.submap_to
        ? t("closure-list.room_submapto", { submapto: closure.submap_to })
        : t("closure-list.room_submapfrom_submapto", { submapfrom: closure.submap_from, submapto: closure.submap_to }),
    );
    const since = t("closure-list.age_ago", { age: age(Math.max(0, now - closure.stamp_s)) });
    write(
      words,
      [STATES[closure.state], t("closure-list.fit_fixed", { fixed: fixed(closure.score, 2) }), since, closure.words]
        .filter(Boolean)
        .join(" · "),
    );
    button.disabled = !may;
    redraw(/** @type {SVGElement} */ (button.firstElementChild), undone ? "redo" : "undo");
    write(/** @type {Element} */ (button.lastElementChild), undone ? t("closure-list.redo") : t("closure-list.undo"));
    mark(
      button,
      "aria-label",
      t("closure-list.value_closure_id", {
        value: undone ? t("closure-list.redo") : t("closure-list.undo"),
        id: closure.id,
      }),
    );
    button.dataset["action"] = undone ? "redo" : "undo";
  }

  /** @param {ClosureRow} closure @returns {Line} */
  #add({ id }) {
    const rooms = make("span.closure-rooms");
    const words = make("span.note");
    const button = make("button.button.small", icon("undo"), make("span", t("closure-list.undo")));
    button.addEventListener(
      "click",
      () => void this.#judge(id, /** @type {"undo" | "redo"} */ (button.dataset["action"])),
    );
    const row = make(
      "li.closure",
      make("span.closure-mark", { "aria-hidden": "true" }),
      make("span.closure-body", rooms, words),
      button,
    );
    const line = { row, rooms, words, button };
    const newer = [...this.#lines].find(([other]) => other < id)?.[1].row ?? null;
    this.#list.insertBefore(row, newer);
    this.#lines.set(id, line);
    this.#lines = new Map([...this.#lines].sort(([a], [b]) => b - a));
    return line;
  }

  /** @param {number} id @param {"undo" | "redo"} action */
  async #judge(id, action) {
    const done = await this.#session?.attempt(() => maps.judge(id, action));
    if (done)
      this.#session?.announce(
        action === "undo"
          ? t("closure-list.closure_id_is_undone", { id })
          : t("closure-list.closure_id_holds_again", { id }),
      );
  }
}

customElements.define("closure-list", ClosureList);

const EVERY_MS = 400;
const COLUMNS = ["#", "x m", "y m", "± cm", t("landmark-table.hits"), t("landmark-table.missed")];

export class LandmarkTable extends HTMLElement {
  #body = make("tbody");
  #empty = make("p.record-empty", t("landmark-table.no_landmark_yet_a_corner_counts"));
  #shownAt = -Infinity;

  connectedCallback() {
    if (this.children.length) return;
    this.tabIndex = 0; // so that Page Up and Page Down reach it
    this.setAttribute("role", "region");
    this.setAttribute("aria-label", t("landmark-table.landmarks"));
    const head = make("tr", ...COLUMNS.map((name) => make("th", { scope: "col" }, name)));
    this.append(
      make(
        "table.landmarks",
        make("caption.visually-hidden", t("landmark-table.landmarks")),
        make("thead", head),
        this.#body,
      ),
      this.#empty,
    );
  }

  /** @param {readonly LandmarkRow[]} landmarks */
  show(landmarks) {
    const now = performance.now();
    if (this.offsetParent === null || now - this.#shownAt < EVERY_MS) return;
    this.#shownAt = now;
    this.#empty.hidden = landmarks.length > 0;
    while (this.#body.rows.length > landmarks.length) this.#body.deleteRow(-1);
    while (this.#body.rows.length < landmarks.length) this.#body.append(make("tr", ...COLUMNS.map(() => make("td"))));
    for (const [index, landmark] of landmarks.entries()) {
      const cells = this.#body.rows[index]?.cells ?? [];
      for (const [column, text] of rowOf(landmark).entries()) write(/** @type {Element} */ (cells[column]), text);
    }
  }
}

/** @param {LandmarkRow} landmark */
function rowOf({ id, x_m: x, y_m: y, cov_m2: covariance, hits, misses }) {
  const uncertain = 100 * largestSigma(covariance);
  return [String(id), fixed(x, 2), fixed(y, 2), fixed(uncertain, 1), String(hits), String(misses)];
}

customElements.define("landmark-table", LandmarkTable);

/** @param {number} high [m] */
const length = (high) => (high < 1 ? { unit: " cm", times: 100 } : { unit: " m", times: 1 });
const plain = () => ({ unit: "", times: 1 });

class SlamCard extends Panel {
  #plots = {
    error: new LivePlot({
      name: t("slam-card.true_error"),
      says: t("slam-card.simulator_only_how_far_the_estimate"),
      claim: t("slam-card.dashed_2_of_its_own"),
      unit: length,
      least: 0.02,
    }),
    nis: new LivePlot({
      name: t("slam-card.surprise_nis"),
      says: t("slam-card.how_far_sightings_lay_from_what"),
      claim: t("slam-card.band_95"),
      unit: plain,
      least: 1.5,
    }),
    match: new LivePlot({
      name: t("slam-card.scan_on_the_map"),
      says: t("slam-card.how_much_of_the_newest_sweep"),
      unit: plain,
      least: 1,
    }),
    update: new LivePlot({
      name: t("slam-card.time_of_an_update"),
      says: t("slam-card.how_long_it_takes_to_see"),
      unit: () => ({ unit: " ms", times: 1 }),
      least: 5,
    }),
  };
  #facts = make("p.note.slam-facts");
  #here = make("button.button.small", icon("here"), make("span", t("slam-card.it_is_here")));
  #closures = new ClosureList();
  #landmarks = new LandmarkTable();
  #seq = -1;

  /** @override */
  build() {
    this.append(
      make("div.inline.slam-top", this.#facts, make("span.spring"), this.#here),
      ...Object.values(this.#plots),
      this.#closures,
      make("div.inline.slam-head", make("h3", t("slam-card.landmarks"))),
      this.#landmarks,
    );
    this.#closures.join(this.session);
    this.#here.addEventListener("click", () => this.dispatchEvent(new CustomEvent("place-robot", { bubbles: true })));
  }

  /** @override @param {View} view */
  show({ state, hello, up }) {
    if (!state) return;
    const { slam, floor } = state;
    if (state.seq !== this.#seq) this.#remember(state);
    this.#seq = state.seq;
    const operates = up && hello?.you.role !== "viewer";
    this.#here.hidden = hello?.robot.drives !== true || hello.you.role === "viewer";
    this.#here.disabled = !operates;
    mark(this.#plots.error, "hidden", slam.error_m === null);
    mark(this.#plots.match, "hidden", floor.match_score === null);
    const { error, nis, match, update } = this.#plots;
    nis.show(slam.nis_band);
    error.note(slam.nees === null ? "" : `NEES ${fixed(slam.nees, 1)}`);
    for (const plot of [error, match, update]) plot.show();
    const rooms = floor.submaps.length;
    const facts = [
      rooms ? `${rooms} ${rooms === 1 ? t("slam-card.room") : t("slam-card.rooms")}` : "",
      `${inLanguage(`${state.landmarks.length} landmarks`)}${slam.tentative ? t("slam-card.tentative_on_trial", { tentative: slam.tentative }) : ""}`,
    ];
    write(this.#facts, facts.filter(Boolean).join(" · "));
    this.#closures.show(floor, state.stamp_s, operates);
    this.#landmarks.show(state.landmarks);
  }

  /** @param {import("../net/messages.js").State} state */
  #remember({ stamp_s: now, slam, floor, pose }) {
    const claim = 2 * Math.sqrt(Math.max(0, (pose.cov[0]?.[0] ?? 0) + (pose.cov[1]?.[1] ?? 0)));
    this.#plots.error.add(now, slam.error_m, slam.error_m === null ? null : claim);
    this.#plots.nis.add(now, slam.nis);
    this.#plots.match.add(now, floor.match_score);
    this.#plots.update.add(now, slam.update_ms);
  }
}

customElements.define("slam-card", SlamCard);
