// Element <place-list>: the named places of the map; a press sends the robot there.

import { marksOf, removePlace, removeZone, wordsTo } from "../net/marks-api.js";
import { icon, iconButton, isNew, make } from "../ui/element.js";
import { degrees, fixed } from "../ui/format.js";
import { Panel } from "../ui/panel.js";
import { refill } from "../ui/press.js";
import { sure } from "../ui/row-question.js";
import { t } from "../ui/texts.js";

/** @import { Place } from "../net/marks-api.js" */
/** @import { ZoneRow as Zone } from "../net/rest.js" */
/** @import { View } from "../net/session.js" */

/** @param {Element} from @param {{place?: Place, at?: {x: number, y: number}}} detail asks for a name */
export const askName = (from, detail) =>
  from.dispatchEvent(new CustomEvent("name-place", { detail, bubbles: true, composed: true }));

class PlaceList extends Panel {
  #remember = make("button.button", icon("pin"), make("span", t("place-list.remember_this_place")));
  #empty = make("p.note", t("place-list.none_yet"));
  #list = make("ul.places", { "aria-label": t("place-list.places") });
  #noZone = make("p.note", t("place-list.no_zone_yet"));
  #zones = make("ul.places", { "aria-label": t("place-list.zones") });
  #operates = false;
  #drives = false;

  /** @override */
  build() {
    const head = make("h3", t("place-list.places"));
    this.append(
      make("div.inline.slam-head", head, make("span.spring"), this.#remember),
      this.#empty,
      this.#list,
      make("div.inline.slam-head", make("h3", t("place-list.zones"))),
      this.#noZone,
      this.#zones,
    );
    this.#remember.addEventListener("click", () => askName(this, {}));
    marksOf(this.session).addEventListener("change", () => this.#draw());
  }

  /** @override @param {View} view */
  show({ hello, up }) {
    this.#operates = hello !== null && hello.you.role !== "viewer";
    this.#drives = this.#operates && hello?.robot.drives === true;
    this.#remember.hidden = !this.#drives;
    this.#draw();
    for (const button of this.querySelectorAll("button")) button.disabled = !up;
  }

  #draw() {
    const { places, zones } = marksOf(this.session);
    if (!isNew(this, places, zones, this.#operates, this.#drives)) return;
    this.#empty.hidden = places.length > 0;
    refill(this.#list, ...places.map((place) => this.#row(place)));
    this.#noZone.hidden = zones.length > 0 || !this.#operates;
    refill(this.#zones, ...zones.map((zone) => this.#zoneRow(zone)));
  }

  /** @param {string} name @param {(name: string) => Promise<unknown>} remove */
  #remover(name, remove) {
    return remover(name, () => this.session.attempt(() => remove(name)));
  }

  /** @param {Zone} zone */
  #zoneRow({ name, kind, max_speed_m_s: speed }) {
    const says =
      kind === "keep_out" ? t("place-list.keep_out") : t("place-list.at_most_speed", { speed: fixed(speed ?? 0, 2) });
    const body = make("div.place-body", make("p.place-name", name), make("p.note", says));
    return make("li.row.place", { "data-kind": kind }, body, this.#operates && this.#remover(name, removeZone));
  }

  /** @param {Place} place */
  #row(place) {
    const turned = place.heading_rad === null ? "" : `, ${degrees(place.heading_rad)}`;
    const where = `${fixed(place.x_m, 2)}, ${fixed(place.y_m, 2)} m${turned}`;
    const go = make(
      "button.button.place-go",
      {
        "aria-label": t("place-list.go_to_name", { name: place.name }),
        onclick: () => void this.session.say(wordsTo(place), "click"),
      },
      t("place-list.go"),
    );
    const more = { title: t("place-list.change"), look: "small" };
    const says = t("place-list.change_name", { name: place.name });
    const edit = iconButton("pencil", says, () => askName(this, { place }), more);
    const away = this.#remover(place.name, removePlace);
    const body = make("div.place-body", make("p.place-name", place.name), make("p.note", where));
    return make("li.row.place", body, this.#drives && go, this.#operates && edit, this.#operates && away);
  }
}

/** A button that asks once more. @param {string} name @param {() => unknown} remove */
export function remover(name, remove) {
  const away = make(
    "button.button.plain",
    { "aria-label": t("place-list.remove_name", { name }) },
    t("place-list.remove"),
  );
  away.addEventListener("click", () => sure(away, t("place-list.remove_it")) && remove());
  return away;
}

customElements.define("place-list", PlaceList);
