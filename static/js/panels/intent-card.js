// What was understood, before the robot moves: the order with its numbers, where it goes, and the moment to hold it back.

import { icon, make, mark, redraw, write } from "../element.js";
import { begun, countdown, facts, left, mayBegin, speaker, title } from "../intent.js";
import { Panel } from "../panel.js";

/** @typedef {import("../session.js").View} View */
/** @typedef {import("../wire.js").IntentState} IntentState */

const SHOWN_MS = 2500; // that an order which has begun is shown

class IntentCard extends Panel {
  #icon = icon("command");
  #title = make("p", { class: "intent-title" });
  #facts = make("p", { class: "intent-facts" });
  #when = make("span", { class: "intent-when", role: "timer" });
  #fill = make("div", { class: "intent-fill" });
  #go = make(
    "button",
    { type: "button", class: "button primary", "aria-keyshortcuts": "Enter" },
    "Go now",
    make("kbd", { "aria-hidden": "true" }, "Enter"),
  );
  #cancel = make(
    "button",
    { type: "button", class: "button", "aria-label": "Cancel the waiting order", "aria-keyshortcuts": "Escape" },
    icon("close"),
    "Cancel",
    make("kbd", { "aria-hidden": "true" }, "Esc"),
  );
  #waiting = 0; // id of the order that waits
  /** @type {number | null} id of the newest command that was begun; null before the first state */
  #begun = null;
  #until = 0; // [ms] that it is shown

  /** @override */
  build() {
    this.classList.add("card");
    this.hidden = true;
    mark(this, "role", "region");
    mark(this, "aria-label", "Spoken order");
    this.append(
      this.#icon,
      make("div", { class: "intent-words" }, this.#title, this.#facts),
      make("div", { class: "intent-ways" }, this.#when, this.#go, this.#cancel),
      make("div", { class: "intent-bar", "aria-hidden": "true" }, this.#fill),
    );
    this.#go.addEventListener("click", () => this.#press(this.#go, this.session.beginIntent(this.#waiting)));
    this.#cancel.addEventListener("click", () => this.#press(this.#cancel, this.session.dropIntent(this.#waiting)));
  }

  /**
   * @override
   * @param {View} view
   */
  show(view) {
    const { state, up } = view;
    const intent = (up && state?.intent) || null;
    const command = begun(view);
    if (state && command?.id !== this.#begun) {
      const fresh = command !== null && this.#begun !== null; // what ran when the page was opened is old news
      if (fresh) this.#until = performance.now() + SHOWN_MS;
      if (command || this.#begun === null) this.#begun = command?.id ?? 0;
    }
    if (intent && state) this.#wait(intent, view);
    else if (command && performance.now() < this.#until) {
      this.#draw(command.name, title(command), speaker(command), "begun");
      write(this.#when, "begun");
    }
    this.hidden = !intent && !(command && performance.now() < this.#until);
    if (!intent) this.#waiting = 0;
  }

  /**
   * @param {IntentState} intent
   * @param {View} view
   */
  #wait(intent, view) {
    const { state } = view;
    if (!state) return;
    const told = facts(intent, state.pose);
    this.#draw(intent.name, title(intent), told, intent.unsure ? "unsure" : "waiting");
    write(this.#when, countdown(intent));
    this.#fill.style.width = `${(100 * left(intent)).toFixed(1)}%`;
    this.#go.hidden = mayBegin(view) === null;
    if (intent.id === this.#waiting) return;
    this.#waiting = intent.id;
    this.#go.disabled = this.#cancel.disabled = false;
    const keys = this.#go.hidden ? "Escape stops it." : "Enter begins it now, Escape stops it.";
    this.session.announce(`${title(intent)} ${countdown(intent)}. ${told}. ${keys}`);
  }

  /**
   * @param {string} name
   * @param {string} words
   * @param {string} facts
   * @param {"waiting" | "unsure" | "begun"} state
   */
  #draw(name, words, facts, state) {
    redraw(this.#icon, name);
    write(this.#title, words);
    write(this.#facts, facts);
    mark(this, "data-state", state);
  }

  /**
   * One press, one answer: until it is there the button waits.
   * @param {HTMLButtonElement} button
   * @param {Promise<void>} answer
   */
  #press(button, answer) {
    button.disabled = true;
    void answer.finally(() => (button.disabled = false));
  }
}

customElements.define("intent-card", IntentCard);
