// Whom the robot comes to: anybody, or one of those whom it knows.

import { action } from "../calibration/action.js";
import { since } from "../calibration/used.js";
import { icon, make, write } from "../element.js";
import { Panel } from "../panel.js";

/** @typedef {import("./lessons.js").Lessons} Lessons */
/** @typedef {import("./lessons.js").Known} Known */

class PeopleKnown extends Panel {
  /** @type {Lessons | null} */
  #lessons = null;
  #rows = make("ul", { class: "known-rows" });
  #call = action("voice", "Try it: let them call “come here”");
  #leave = action("close", "Send them away");
  #outcome = make("p", { class: "known-outcome", role: "status" });
  #trial = make(
    "div",
    { class: "known-trial", hidden: true },
    make(
      "p",
      { class: "note" },
      "Who showed you the gestures stands in the simulated room still; let them call, and see whether I come.",
    ),
    make("div", { class: "people-buttons" }, this.#call, this.#leave),
    this.#outcome,
  );
  /** @type {{id: string, what: "rename" | "forget"} | null} who is asked about, instead of their row */
  #asked = null;
  #drawn = "";

  /** @param {Lessons} lessons */
  watch(lessons) {
    this.#lessons = lessons;
    lessons.onChange(() => this.#draw());
  }

  /** @override */
  build() {
    this.#call.addEventListener("click", () => void this.#lessons?.call());
    this.#leave.addEventListener("click", () => void this.#lessons?.sendAway());
    this.append(
      make(
        "section",
        { class: "card people-card", "aria-label": "Whom I come to" },
        make("h2", {}, "Whom do I come to?"),
        this.#rows,
        this.#trial,
        make(
          "p",
          { class: "note" },
          "It is meant for COME HERE and FOLLOW ME. Everything else is obeyed as before, and STOP from everybody.",
        ),
        make("p", { class: "note" }, "I know people by their clothes: in others, teach me anew."),
      ),
    );
  }

  #draw() {
    const lessons = this.#lessons;
    if (!lessons?.told) return;
    this.#trial.hidden = !lessons.told.stands || lessons.enrolment !== null || !lessons.may;
    this.#call.disabled = this.#leave.disabled = lessons.busy;
    write(this.#outcome, lessons.outcome);
    const { people, chosen } = lessons.told;
    const key = JSON.stringify([people, chosen, lessons.may, this.#asked]);
    if (key === this.#drawn) return;
    this.#drawn = key;
    const held = this.#rows.contains(document.activeElement) ? document.activeElement?.getAttribute("value") : null;
    const anybody = this.#choice(null, chosen === null, "Anybody", "Whoever calls");
    this.#rows.replaceChildren(make("li", {}, anybody), ...people.map((one) => this.#row(one, one.id === chosen)));
    const again = [...this.#rows.querySelectorAll("input")].find((one) => one.value === held);
    if (this.#asked === null) again?.focus();
  }

  /** @param {Known} one @param {boolean} chosen */
  #row(one, chosen) {
    if (this.#asked?.id === one.id)
      return make("li", {}, this.#asked.what === "rename" ? this.#rename(one) : this.#farewell(one));
    const row = make(
      "li",
      {},
      this.#choice(one.id, chosen, `Only ${one.name}`, `Learnt ${since(one.learnt_s)} from ${one.pictures} pictures`),
    );
    if (!this.#lessons?.may) return row;
    const other = make(
      "button",
      { type: "button", class: "icon-button", "aria-label": `Rename ${one.name}`, title: "Rename" },
      icon("typed"),
    );
    other.addEventListener("click", () => this.#ask({ id: one.id, what: "rename" }));
    const away = make(
      "button",
      { type: "button", class: "icon-button", "aria-label": `Forget ${one.name}`, title: "Forget" },
      icon("trash"),
    );
    away.addEventListener("click", () => this.#ask({ id: one.id, what: "forget" }));
    row.append(other, away);
    return row;
  }

  /** @param {string | null} id @param {boolean} chosen @param {string} name @param {string} note */
  #choice(id, chosen, name, note) {
    const lessons = this.#lessons;
    const radio = make("input", {
      type: "radio",
      name: "chosen",
      value: id ?? "",
      checked: chosen,
      disabled: !lessons?.may,
    });
    radio.addEventListener("change", () => void this.#choose(id));
    return make(
      "label",
      { class: "known-choice" },
      radio,
      make("span", {}, make("span", { class: "known-name" }, name), make("span", { class: "note" }, note)),
    );
  }

  /** @param {string | null} id */
  async #choose(id) {
    const done = await this.#lessons?.choose(id);
    if (done) return;
    this.#drawn = ""; // what was pressed did not come true
    this.#draw();
  }

  /** @param {{id: string, what: "rename" | "forget"} | null} asked */
  #ask(asked) {
    this.#asked = asked;
    this.#draw();
    /** @type {HTMLElement | null} */ (this.querySelector(".known-asked :is(input, button)"))?.focus();
  }

  /** @param {Known} one */
  #rename(one) {
    const input = make("input", { type: "text", maxlength: "40", value: one.name, "aria-label": "Name" });
    return this.#question(
      [input],
      "Rename",
      "Leave the name as it is",
      () => void this.#lessons?.rename(one.id, input.value),
    );
  }

  /** @param {Known} one */
  #farewell(one) {
    const words = make("span", { class: "known-name" }, `Forget ${one.name} for good?`);
    return this.#question([words], "Forget", `Keep ${one.name}`, () => void this.#lessons?.forget(one.id));
  }

  /** @param {HTMLElement[]} what @param {string} yes @param {string} no @param {() => void} act */
  #question(what, yes, no, act) {
    const away = make("button", { type: "button", class: "icon-button", "aria-label": no, title: no }, icon("close"));
    const form = make(
      "form",
      { class: "known-asked" },
      ...what,
      make("button", { type: "submit", class: "button primary" }, yes),
      away,
    );
    away.addEventListener("click", () => this.#ask(null));
    form.addEventListener("keydown", (event) => event.key === "Escape" && this.#ask(null));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.#asked = null;
      act();
    });
    return form;
  }
}

customElements.define("people-known", PeopleKnown);
