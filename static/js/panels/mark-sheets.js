// Element <place-sheet>: the name of a place, and where the robot looks there.
// Element <zone-sheet>: the name of a zone that was drawn, and what holds in it.
// Base class of the dialogs that name something on the map and save it.

import { addPlace, addZone, changePlace } from "../net/marks-api.js";
import { make, nameField, numberField, onSubmit, write } from "../ui/element.js";
import { fixed, spread } from "../ui/format.js";
import { Sheet } from "../ui/sheet.js";
import { t } from "../ui/texts.js";
import { TroubleLine } from "../ui/trouble-line.js";

/** @import { Place } from "../net/marks-api.js" */

export class NameSheet extends Sheet {
  #name = nameField("", { id: "" });
  #trouble = new TroubleLine();
  #keep = make("button.button.primary", { type: "submit" }, t("place-sheet.save"));
  #asked = 0; // number of the question

  /**
   * Build it, closed.
   * @param {{id: string, title: string, label: string, example: string}} words `id` of the field
   * @param {(Node | string)[]} above the name
   * @param {(Node | string)[]} below
   */
  fill({ id, title, label, example }, above, below) {
    [this.#name.id, this.#name.placeholder] = [id, example];
    const named = make("label", { for: id }, label);
    const form = make("form.place-sheet-form", ...above, named, this.#name, ...below);
    form.append(this.#trouble.element, this.#keep);
    this.frame(title, form);
    onSubmit(form, () => void this.#save());
  }

  /** @param {string} name that is offered */
  ask(name) {
    this.#name.value = name;
    this.#asked += 1;
    this.#keep.disabled = false; // what was asked before may still be saved
    write(this.#keep, t("place-sheet.save"));
    this.#trouble.say("");
    if (this.hasAttribute("hidden")) this.toggle();
    this.#name.focus();
    this.#name.select();
  }

  /** @param {string} _name @returns {Promise<string>} what is announced */
  async save(_name) {
    return "";
  }

  async #save() {
    const name = this.#name.value.trim();
    if (!name) {
      this.#trouble.say(t("place-sheet.a_name_is_missing"));
      this.#name.focus();
      return;
    }
    const asked = this.#asked;
    await this.#trouble.attempt(async () => {
      this.session.announce(await this.save(name));
      if (asked === this.#asked) this.shut();
    }, this.#keep);
  }
}

const DEGREE = Math.PI / 180;
const SPARE_M = 0.035; // as the planner keeps free at least

class PlaceSheet extends NameSheet {
  #where = make("p.note");
  #turns = make("input", { type: "checkbox", onchange: () => (this.#degrees.disabled = !this.#turns.checked) });
  #degrees = numberField(t("place-sheet.heading_in_degrees"), { min: -360, max: 360, step: 1 }, "place-degrees");
  /** @type {Place | null} that is changed; null: a new one */
  #place = null;
  /** @type {{x: number, y: number}} [m] */
  #at = { x: 0, y: 0 };

  /** @override */
  build() {
    const heading = make("label.inline", this.#turns, t("place-sheet.look_that_way"));
    this.fill(
      {
        id: "place-name",
        title: t("place-sheet.name_this_place"),
        label: t("place-sheet.name"),
        example: t("place-sheet.kitchen"),
      },
      [this.#where],
      [make("div.inline.place-heading", heading, this.#degrees, "°")],
    );
    addEventListener("name-place", (event) => this.#open(/** @type {CustomEvent} */ (event).detail));
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
    const turned = place ? place.heading_rad : null;
    this.#turns.checked = turned !== null;
    this.#degrees.disabled = turned === null;
    this.#degrees.value = String(Math.round((turned ?? heading) / DEGREE));
    this.ask(place?.name ?? "");
  }

  /** @override @param {string} name */
  async save(name) {
    const heading = this.#turns.checked ? (this.#degrees.valueAsNumber || 0) * DEGREE : null;
    const wrapped = heading === null ? null : Math.atan2(Math.sin(heading), Math.cos(heading));
    const place = { name, x_m: this.#at.x, y_m: this.#at.y, heading_rad: wrapped };
    const kept = await (this.#place ? changePlace(this.#place.name, place) : addPlace(place));
    const radius = this.session.hello?.robot.radius_m ?? 0;
    if (typeof kept.wall_m === "number" && kept.wall_m < radius + SPARE_M)
      this.session.complain(t("place-sheet.near_a_wall", { name: kept.name, wall: spread(kept.wall_m).slice(2) }));
    return t("place-sheet.name_is_saved", { name: kept.name });
  }
}

customElements.define("place-sheet", PlaceSheet);

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
