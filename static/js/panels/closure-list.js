// Places that were recognised: which rooms they joined, how well they fit, and whether they shall hold.

import { icon, make, mark, redraw, write } from "../element.js";
import { age, fixed } from "../format.js";
import * as maps from "../maps.js";

/** @typedef {import("../session.js").Session} Session */
/** @typedef {import("../wire.js").FloorState} FloorState */
/** @typedef {import("../wire.js").ClosureRow} ClosureRow */
/** @typedef {{row: HTMLLIElement, rooms: Element, words: Element, button: HTMLButtonElement}} Line */

const STATES = { accepted: "holds", undone: "undone", doubtful: "doubtful" };

export class ClosureList extends HTMLElement {
  #list = make("ol", { class: "closures", "aria-label": "Closures, newest first" });
  #count = make("span", { class: "note" });
  #empty = make(
    "p",
    { class: "note closures-empty" },
    "None yet. When the robot comes back to a place that it knows, the rooms between are pulled straight.",
  );
  #all = make("button", { type: "button", class: "button wide", hidden: true });
  /** @type {Map<number, Line>} */
  #lines = new Map();
  /** @type {Session | null} */
  #session = null;
  /** @type {ClosureRow[]} older ones than those that come with every state */
  #older = [];

  /** @param {Session} session */
  join(session) {
    this.#session = session;
    this.append(
      make("div", { class: "slam-head" }, make("h3", {}, "Closures"), make("span", { class: "spring" }), this.#count),
      this.#empty,
      this.#list,
      this.#all,
    );
    this.#all.addEventListener("click", () => void this.#fetch());
  }

  /**
   * @param {FloorState} floor
   * @param {number} now [s], robot clock
   * @param {boolean} may undo and redo
   */
  show({ closures, closures_count: count }, now, may) {
    if (this.offsetParent === null) return;
    const newest = new Set(closures.map(({ id }) => id));
    const rows = [...this.#older.filter(({ id }) => !newest.has(id)), ...closures].slice(-count || closures.length);
    const accepted = closures.filter(({ state }) => state === "accepted").length;
    write(this.#count, count > closures.length ? `${count}` : count ? `${accepted} of ${count} hold` : "");
    this.#empty.hidden = count > 0;
    this.#all.hidden = rows.length >= count;
    write(this.#all, `Show ${count - rows.length} older`);
    for (const [id, { row }] of this.#lines) {
      if (rows.some((told) => told.id === id)) continue;
      row.remove();
      this.#lines.delete(id);
    }
    for (const told of rows) this.#fill(this.#lines.get(told.id) ?? this.#add(told), told, now, may);
  }

  /**
   * @param {Line} line
   * @param {ClosureRow} told
   * @param {number} now
   * @param {boolean} may
   */
  #fill({ row, rooms, words, button }, told, now, may) {
    const undone = told.state === "undone";
    mark(row, "data-state", told.state);
    write(
      rooms,
      told.submap_from === told.submap_to ? `Room ${told.submap_to}` : `Room ${told.submap_from} → ${told.submap_to}`,
    );
    const since = `${age(Math.max(0, now - told.stamp_s))} ago`;
    write(words, [STATES[told.state], `fit ${fixed(told.score, 2)}`, since, told.words].filter(Boolean).join(" · "));
    button.disabled = !may;
    redraw(/** @type {SVGElement} */ (button.firstElementChild), undone ? "redo" : "undo");
    write(/** @type {Element} */ (button.lastElementChild), undone ? "Redo" : "Undo");
    mark(button, "aria-label", `${undone ? "Redo" : "Undo"} closure ${told.id}`);
    button.dataset["wish"] = undone ? "redo" : "undo";
  }

  /** @param {ClosureRow} told @returns {Line} */
  #add({ id }) {
    const rooms = make("span", { class: "closure-rooms" });
    const words = make("span", { class: "note" });
    const button = make("button", { type: "button", class: "button small" }, icon("undo"), make("span", {}, "Undo"));
    button.addEventListener(
      "click",
      () => void this.#judge(id, /** @type {"undo" | "redo"} */ (button.dataset["wish"])),
    );
    const row = make(
      "li",
      { class: "closure" },
      make("span", { class: "closure-mark", "aria-hidden": "true" }),
      make("span", { class: "closure-body" }, rooms, words),
      button,
    );
    const line = { row, rooms, words, button };
    const newer = [...this.#lines].find(([other]) => other < id)?.[1].row ?? null;
    this.#list.insertBefore(row, newer);
    this.#lines.set(id, line);
    this.#lines = new Map([...this.#lines].sort(([a], [b]) => b - a));
    return line;
  }

  /** @param {number} id @param {"undo" | "redo"} wish */
  async #judge(id, wish) {
    try {
      await maps.judge(id, wish);
      this.#session?.announce(wish === "undo" ? `Closure ${id} is undone.` : `Closure ${id} holds again.`);
    } catch (refusal) {
      this.#session?.complain(/** @type {Error} */ (refusal).message);
    }
  }

  async #fetch() {
    try {
      this.#older = await maps.closures();
    } catch (refusal) {
      this.#session?.complain(/** @type {Error} */ (refusal).message);
    }
  }
}

customElements.define("closure-list", ClosureList);
