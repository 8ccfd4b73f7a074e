// Element <people-known>: list of known people; selects the one that the robot comes to.

import { since } from "../calibration/active-calibration.js";
import { fetchLookingModel, looking } from "../net/api.js";
import { action, iconButton, isNew, make, nameField, onSubmit, write } from "../ui/element.js";
import { ModelOffer } from "../ui/model-offer.js";
import { PagePanel } from "../ui/panel.js";
import { t } from "../ui/texts.js";

/** @import { KnownPerson as Known } from "../net/rest.js" */
/** @import { EnrollmentModel } from "./enrollment-model.js" */

/** @extends {PagePanel<EnrollmentModel>} */
class PeopleKnown extends PagePanel {
  #rows = make("ul.known-rows");
  #call = action("voice", t("people-known.try_it_let_them_call_come"), () => void this.model.call());
  #leave = action("close", t("people-known.send_them_away"), () => void this.model.sendAway());
  #outcome = make("p.known-outcome", { role: "status" });
  #trial = make(
    "div.known-trial",
    { hidden: true },
    make("p.note", t("people-known.the_simulated_person_is_still_in")),
    make("div.row.people-buttons", this.#call, this.#leave),
    this.#outcome,
  );
  #offer = new ModelOffer(looking, fetchLookingModel, async (act) => this.model.session.attempt(act));
  /** @type {{id: string, what: "rename" | "forget"} | null} person whose row shows a question */
  #asked = null;

  /** @override @param {EnrollmentModel} model */
  watch(model) {
    super.watch(model);
    model.session.on("hello", () => void this.#offer.show());
  }

  /** @override */
  build() {
    this.append(
      make(
        "section.card.page-card",
        { "aria-label": t("people-known.whom_the_robot_comes_to") },
        make("h2", t("people-known.whom_does_the_robot_come_to")),
        this.#rows,
        this.#trial,
        make("p.note", t("people-known.this_applies_to_come_here_and")),
        make("p.note", t("people-known.the_robot_knows_people_by_their")),
        ...this.#offer.elements,
      ),
    );
  }

  /** @override */
  draw() {
    const enrollments = this.model;
    if (!enrollments?.state) return;
    this.#trial.hidden = !enrollments.state.stands || enrollments.enrollment !== null || !enrollments.may;
    this.#call.disabled = this.#leave.disabled = enrollments.busy !== "";
    write(this.#outcome, enrollments.outcome);
    const { people, chosen } = enrollments.state;
    if (!isNew(this, people, chosen, enrollments.may, this.#asked)) return;
    const held = this.#rows.contains(document.activeElement) ? document.activeElement?.getAttribute("value") : null;
    const anybody = this.#choice(null, chosen === null, t("people-known.anybody"), t("people-known.every_caller"));
    this.#rows.replaceChildren(make("li", anybody), ...people.map((one) => this.#row(one, one.id === chosen)));
    const again = [...this.#rows.querySelectorAll("input")].find((one) => one.value === held);
    if (this.#asked === null) again?.focus();
  }

  /** @param {Known} one @param {boolean} chosen */
  #row(one, chosen) {
    if (this.#asked?.id === one.id)
      return make("li", this.#asked.what === "rename" ? this.#rename(one) : this.#farewell(one));
    const row = make(
      "li",
      this.#choice(
        one.id,
        chosen,
        t("people-known.only_name", { name: one.name }),
        t("people-known.learnt_since_from_pictures_pictures", { since: since(one.learnt_s), pictures: one.pictures }),
        one.colours,
      ),
    );
    if (!this.model.may) return row;
    /** @param {"rename" | "forget"} what @param {string} says @param {string} words */
    const act = (what, says, words) =>
      make("button.button.small.plain", { "aria-label": says, onclick: () => this.#ask({ id: one.id, what }) }, words);
    const { name } = one;
    const rename = act("rename", t("people-known.rename_name", { name }), t("people-known.rename"));
    const forget = act("forget", t("people-known.forget_name", { name }), t("people-known.forget"));
    row.append(make("div.known-acts", rename, forget));
    return row;
  }

  /**
   * @param {string | null} id @param {boolean} chosen @param {string} name @param {string} note
   * @param {readonly (string | null)[]} [colours] of head, torso, legs
   */
  #choice(id, chosen, name, note, colours = [null, null, null]) {
    const radio = make("input", {
      type: "radio",
      name: "chosen",
      value: id ?? "",
      checked: chosen,
      disabled: !this.model.may,
    });
    radio.addEventListener("change", () => void this.#choose(id));
    return make(
      "label.known-choice",
      figure(colours),
      radio,
      make("span", make("span.known-name", name), make("span.note", note)),
    );
  }

  /** @param {string | null} id */
  async #choose(id) {
    const done = await this.model.choose(id);
    if (done) return;
    isNew(this); // restore the former choice
    this.draw();
  }

  /** @param {{id: string, what: "rename" | "forget"} | null} asked */
  #ask(asked) {
    this.#asked = asked;
    this.draw();
    /** @type {HTMLElement | null} */ (this.querySelector(".known-asked :is(input, button)"))?.focus();
  }

  /** @param {Known} one */
  #rename(one) {
    const input = nameField(t("people-known.name"), { value: one.name });
    return this.#question(
      [input],
      t("people-known.rename"),
      t("people-known.leave_the_name_as_it_is"),
      () => void this.model.rename(one.id, input.value),
    );
  }

  /** @param {Known} one */
  #farewell(one) {
    const words = make("span.known-name", t("people-known.forget_name_for_good", { name: one.name }));
    return this.#question(
      [words],
      t("people-known.forget"),
      t("people-known.keep_name", { name: one.name }),
      () => void this.model.forget(one.id),
    );
  }

  /** @param {HTMLElement[]} what @param {string} yes @param {string} no @param {() => void} act */
  #question(what, yes, no, act) {
    const away = iconButton("close", no, () => this.#ask(null), { title: no });
    const form = make("form.inline.known-asked", ...what, make("button.button.primary", { type: "submit" }, yes), away);
    form.addEventListener("keydown", (event) => event.key === "Escape" && this.#ask(null));
    onSubmit(form, () => {
      this.#asked = null;
      act();
    });
    return form;
  }
}

/** A person in the colours of their clothes. @param {readonly (string | null)[]} colours of head, torso, legs */
function figure(colours) {
  const parts = colours.map((colour) => {
    const part = make("span");
    if (colour) part.style.background = colour;
    return part;
  });
  return make("span.known-figure", { "aria-hidden": "true" }, ...parts);
}

customElements.define("people-known", PeopleKnown);
