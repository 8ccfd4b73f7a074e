// Element <join-card>: two saved maps of one building, where one lies in the other, and joined when a person says so.

import { address } from "../net/api.js";
import * as maps from "../net/maps-api.js";
import { make, nameField, onSubmit, write } from "../ui/element.js";
import { degrees, fixed, share } from "../ui/format.js";
import { Panel } from "../ui/panel.js";
import { t } from "../ui/texts.js";
import { TroubleLine } from "../ui/trouble-line.js";

/** @import { View } from "../net/session.js" */

class JoinCard extends Panel {
  #older = make("select.field-box", { "aria-label": t("join-card.older_map") });
  #newer = make("select.field-box", { "aria-label": t("join-card.newer_map") });
  #look = make("button.button", { onclick: () => void this.#try(() => this.#show()) }, t("join-card.match"));
  #trouble = new TroubleLine();
  #words = make("p", { role: "status" });
  #picture = make("img.join-picture", { alt: t("join-card.both_maps_over_each_other") });
  #name = nameField(t("join-card.name_of_the_joined_map"));
  #join = make("button.button.primary", { type: "submit" }, t("join-card.join"));
  #leave = make("button.button", { onclick: () => (this.#question.hidden = true) }, t("map-card.leave_it"));
  #question = make("form.join-question", { hidden: true });
  #revision = -1;
  #match = "";

  /** @override */
  build() {
    const row = make("div.row.nav2-form", this.#older, this.#newer, this.#look);
    const acts = make("div.row.nav2-form", this.#name, this.#leave, this.#join);
    this.#question.append(this.#words, this.#picture, acts);
    const about = make("p.note", t("join-card.two_maps_of_one_building"));
    this.append(make("h3", t("join-card.join_two_maps")), about, row, this.#trouble.element, this.#question);
    onSubmit(this.#question, () => {
      void this.#try(async () => {
        const kept = await maps.join(this.#match, this.#name.value.trim());
        this.#question.hidden = true;
        this.session.announce(t("join-card.the_map_name_is_kept", { name: kept.name }));
      });
    });
  }

  /** @override @param {View} view */
  show({ state, hello }) {
    this.hidden = hello === null || hello.you.role === "viewer";
    if (!state || this.hidden || this.offsetParent === null || state.map.revision === this.#revision) return;
    this.#revision = state.map.revision;
    void maps.list().then(
      (found) => {
        for (const [select, words] of /** @type {const} */ ([
          [this.#older, t("join-card.older_map")],
          [this.#newer, t("join-card.newer_map")],
        ])) {
          const chosen = select.value;
          const options = found.map(({ name }) => make("option", { value: name }, name));
          select.replaceChildren(make("option", { value: "" }, words), ...options);
          select.value = found.some(({ name }) => name === chosen) ? chosen : "";
        }
      },
      () => (this.#revision = -1),
    );
  }

  async #show() {
    const found = await maps.match(this.#older.value, this.#newer.value);
    this.#match = found.id;
    const where = `${fixed(found.x_m, 2)}, ${fixed(found.y_m, 2)} m, ${degrees(found.heading_rad)}`;
    const values = { ...found, where, same: share(found.overlap), against: share(found.conflict) };
    write(this.#words, t("join-card.newer_lies_there", values));
    this.#picture.src = address(`api/maps/match/${found.id}.png`).href;
    this.#question.hidden = false;
  }

  /** @param {() => Promise<unknown>} act */
  async #try(act) {
    this.#look.disabled = this.#join.disabled = true;
    await this.#trouble.attempt(act);
    this.#look.disabled = this.#join.disabled = false;
  }
}

customElements.define("join-card", JoinCard);
