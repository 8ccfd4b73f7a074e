// Element <closure-list>: loop closures with their rooms and scores, and buttons to undo or redo them.

import * as maps from "../net/maps-api.js";
import { icon, make, mark, redraw, write } from "../ui/element.js";
import { age, fixed } from "../ui/format.js";
import { t } from "../ui/texts.js";

/** @import { ClosureRow, SubmapsState as FloorState } from "../net/messages.js" */
/** @import { Session } from "../net/session.js" */
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
  #all = make("button.button.wide", { hidden: true, onclick: () => void this.#fetch() });
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

  async #fetch() {
    await this.#session?.attempt(async () => {
      this.#older = await maps.closures();
    });
  }
}

customElements.define("closure-list", ClosureList);
