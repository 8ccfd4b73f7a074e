// Element <zone-sheet>: the name of a zone that was drawn, and what holds in it.

import { addZone } from "../net/marks-api.js";
import { make } from "../ui/element.js";
import { Sheet } from "../ui/sheet.js";
import { t } from "../ui/texts.js";
import { TroubleLine } from "../ui/trouble-line.js";

export class ZoneSheet extends Sheet {
  #name = make("input", {
    id: "zone-name",
    class: "field-box",
    type: "text",
    maxlength: "40",
    autocomplete: "off",
    placeholder: t("zone-sheet.stairs"),
  });
  #keepOut = make("input", { type: "radio", name: "zone-kind", checked: true });
  #slow = make("input", { type: "radio", name: "zone-kind" });
  #speed = make("input", {
    class: "field-box place-degrees",
    type: "number",
    min: "0.02",
    max: "1",
    step: "0.01",
    value: "0.05",
    disabled: true,
    "aria-label": t("zone-sheet.speed_in_metres_a_second"),
  });
  #trouble = new TroubleLine();
  #keep = make("button", { type: "submit", class: "button primary" }, t("place-sheet.save"));
  /** @type {Array<[number, number]>} [m] */
  #points = [];

  /** @override */
  build() {
    const form = make(
      "form",
      { class: "place-sheet-form" },
      make("label", { for: "zone-name" }, t("zone-sheet.name")),
      this.#name,
      make("label", { class: "place-turns" }, this.#keepOut, t("zone-sheet.the_robot_keeps_out")),
      make(
        "div",
        { class: "place-heading" },
        make("label", { class: "place-turns" }, this.#slow, t("zone-sheet.slow_at_most")),
        this.#speed,
        "m/s",
      ),
      this.#trouble.element,
      this.#keep,
    );
    this.frame(t("zone-sheet.this_zone"), form);
    addEventListener("name-zone", (event) => this.#open(/** @type {CustomEvent} */ (event).detail.points));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      void this.#save();
    });
    for (const box of [this.#keepOut, this.#slow])
      box.addEventListener("change", () => (this.#speed.disabled = !this.#slow.checked));
    this.#name.addEventListener("keydown", (event) => event.key !== "Escape" && event.stopPropagation());
  }

  /** @param {Array<[number, number]>} points [m] */
  #open(points) {
    this.#points = points;
    this.#name.value = "";
    this.#trouble.say("");
    if (this.hasAttribute("hidden")) this.toggle();
    this.#name.focus();
  }

  async #save() {
    const name = this.#name.value.trim();
    if (!name) {
      this.#trouble.say(t("place-sheet.a_name_is_missing"));
      this.#name.focus();
      return;
    }
    const slow = this.#slow.checked;
    this.#keep.disabled = true;
    await this.#trouble.attempt(async () => {
      const kept = await addZone({
        name,
        kind: slow ? "slow" : "keep_out",
        points_m: this.#points,
        max_speed_m_s: slow ? this.#speed.valueAsNumber || 0 : null,
      });
      this.session.announce(t("zone-sheet.name_holds", { name: kept.name }));
      this.shut();
    });
    this.#keep.disabled = false;
  }
}

customElements.define("zone-sheet", ZoneSheet);
