// Element <place-sheet>: the name of a place, and where the robot looks there.

import { addPlace, changePlace } from "../net/marks-api.js";
import { make, write } from "../ui/element.js";
import { fixed } from "../ui/format.js";
import { Sheet } from "../ui/sheet.js";
import { t } from "../ui/texts.js";
import { TroubleLine } from "../ui/trouble-line.js";

/** @typedef {import("../net/marks-api.js").Place} Place */

const DEGREE = Math.PI / 180;

export class PlaceSheet extends Sheet {
  #where = make("p", { class: "note" });
  #name = make("input", {
    id: "place-name",
    class: "field-box",
    type: "text",
    maxlength: "40",
    autocomplete: "off",
    placeholder: t("place-sheet.kitchen"),
  });
  #turns = make("input", { type: "checkbox" });
  #degrees = make("input", {
    class: "field-box place-degrees",
    type: "number",
    min: "-360",
    max: "360",
    step: "1",
    "aria-label": t("place-sheet.heading_in_degrees"),
  });
  #trouble = new TroubleLine();
  #keep = make("button", { type: "submit", class: "button primary" }, t("place-sheet.save"));
  /** @type {Place | null} that is changed; null: a new one */
  #place = null;
  /** @type {{x: number, y: number}} [m] */
  #at = { x: 0, y: 0 };

  /** @override */
  build() {
    const heading = make("label", { class: "place-turns" }, this.#turns, t("place-sheet.look_that_way"));
    const form = make(
      "form",
      { class: "place-sheet-form" },
      this.#where,
      make("label", { for: "place-name" }, t("place-sheet.name")),
      this.#name,
      make("div", { class: "place-heading" }, heading, this.#degrees, "°"),
      this.#trouble.element,
      this.#keep,
    );
    this.frame(t("place-sheet.name_this_place"), form);
    addEventListener("name-place", (event) => this.#open(/** @type {CustomEvent} */ (event).detail));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      void this.#save();
    });
    this.#turns.addEventListener("change", () => (this.#degrees.disabled = !this.#turns.checked));
    this.#name.addEventListener("keydown", (event) => event.key !== "Escape" && event.stopPropagation());
  }

  /** @param {{place?: Place, at?: {x: number, y: number}}} asked */
  #open({ place, at }) {
    const { state } = this.session;
    if (!state) return;
    const { x_m: x, y_m: y, heading_rad: heading } = state.pose;
    this.#place = place ?? null;
    this.#at = place ? { x: place.x_m, y: place.y_m } : (at ?? { x, y });
    const spot = `${fixed(this.#at.x, 2)}, ${fixed(this.#at.y, 2)} m`;
    write(this.#where, place || at ? t("place-sheet.at_spot", { spot }) : t("place-sheet.here_spot", { spot }));
    this.#name.value = place?.name ?? "";
    const turned = place ? place.heading_rad : null;
    this.#turns.checked = turned !== null;
    this.#degrees.disabled = turned === null;
    this.#degrees.value = String(Math.round((turned ?? heading) / DEGREE));
    this.#trouble.say("");
    if (this.hasAttribute("hidden")) this.toggle();
    this.#name.focus();
    this.#name.select();
  }

  async #save() {
    const name = this.#name.value.trim();
    if (!name) {
      this.#trouble.say(t("place-sheet.a_name_is_missing"));
      this.#name.focus();
      return;
    }
    const heading = this.#turns.checked ? (this.#degrees.valueAsNumber || 0) * DEGREE : null;
    const wrapped = heading === null ? null : Math.atan2(Math.sin(heading), Math.cos(heading));
    const place = { name, x_m: this.#at.x, y_m: this.#at.y, heading_rad: wrapped };
    this.#keep.disabled = true;
    await this.#trouble.attempt(async () => {
      const kept = await (this.#place ? changePlace(this.#place.name, place) : addPlace(place));
      this.session.announce(t("place-sheet.name_is_saved", { name: kept.name }));
      this.shut();
    });
    this.#keep.disabled = false;
  }
}

customElements.define("place-sheet", PlaceSheet);
