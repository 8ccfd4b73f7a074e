// Element <zone-sheet>: the name of a zone that was drawn, and what holds in it.

import { addZone } from "../net/marks-api.js";
import { make, numberField } from "../ui/element.js";
import { NameSheet } from "../ui/name-sheet.js";
import { t } from "../ui/texts.js";

class ZoneSheet extends NameSheet {
  #keepOut = make("input", { type: "radio", name: "zone-kind", checked: true });
  #slow = make("input", { type: "radio", name: "zone-kind" });
  #speed = numberField(
    t("zone-sheet.speed_in_metres_a_second"),
    { min: 0.02, max: 1, step: 0.01, value: 0.05, disabled: true },
    "place-degrees",
  );
  /** @type {Array<[number, number]>} [m] */
  #points = [];

  /** @override */
  build() {
    const slow = make("label.inline", this.#slow, t("zone-sheet.slow_at_most"));
    this.fill(
      {
        id: "zone-name",
        title: t("zone-sheet.this_zone"),
        label: t("zone-sheet.name"),
        example: t("zone-sheet.stairs"),
      },
      [],
      [
        make("label.inline", this.#keepOut, t("zone-sheet.the_robot_keeps_out")),
        make("div.inline.place-heading", slow, this.#speed, "m/s"),
      ],
    );
    addEventListener("name-zone", (event) => {
      this.#points = /** @type {CustomEvent} */ (event).detail.points;
      this.ask("");
    });
    for (const box of [this.#keepOut, this.#slow])
      box.addEventListener("change", () => (this.#speed.disabled = !this.#slow.checked));
  }

  /** @override @param {string} name */
  async save(name) {
    const slow = this.#slow.checked;
    const kept = await addZone({
      name,
      kind: slow ? "slow" : "keep_out",
      points_m: this.#points,
      max_speed_m_s: slow ? this.#speed.valueAsNumber || 0 : null,
    });
    return t("zone-sheet.name_holds", { name: kept.name });
  }
}

customElements.define("zone-sheet", ZoneSheet);
