// Element <nav2-card>: take in maps and filter masks of Nav2, take away the zones as masks.

import { address } from "../net/api.js";
import { takeInMap, takeInMask } from "../net/edits-api.js";
import { icon, make, nameField, onSubmit, write } from "../ui/element.js";
import { Panel } from "../ui/panel.js";
import { inLanguage, t } from "../ui/texts.js";
import { TroubleLine } from "../ui/trouble-line.js";

/** @import { View } from "../net/session.js" */

class Nav2Card extends Panel {
  #files = make("input.visually-hidden", {
    type: "file",
    multiple: true,
    accept: ".yaml,.yml,.pgm,.png,.bmp,.zip",
    tabindex: "-1",
    "aria-label": t("nav2-card.files"),
  });
  #chosen = make("span.nav2-chosen", t("nav2-card.choose_files"));
  #choose = make("button.button", { onclick: () => this.#files.click() }, icon("upload"), this.#chosen);
  #name = nameField(t("nav2-card.name"));
  #as = make(
    "select.field-box",
    { "aria-label": t("nav2-card.take_it_in_as") },
    make("option", { value: "map" }, t("nav2-card.a_map")),
    make("option", { value: "keep_out" }, t("nav2-card.zones_to_keep_out_of")),
    make("option", { value: "1 100 -1" }, t("nav2-card.slow_zones_in_percent")),
    make("option", { value: "2 0 0.01" }, t("nav2-card.slow_zones_in_cm_s")),
  );
  #take = make("button.button.primary", { type: "submit" }, icon("done"), t("nav2-card.take_in"));
  #form = make("form.row.nav2-form", this.#as, this.#choose, this.#files, this.#name, this.#take);
  #trouble = new TroubleLine();

  /** @override */
  build() {
    this.append(
      make("h3", t("nav2-card.nav2")),
      make("p.note", t("nav2-card.choose_yaml_and_picture")),
      this.#form,
      this.#trouble.element,
      make(
        "a.map-file",
        { href: address("api/zones/masks").href, download: "" },
        icon("download"),
        make("span", t("nav2-card.zones_as_masks")),
      ),
    );
    onSubmit(this.#form, () => void this.#send());
    this.#files.addEventListener("change", () => this.#tell());
  }

  /** @override @param {View} view */
  show({ hello, up }) {
    this.#form.hidden = hello === null || hello.you.role === "viewer";
    this.#take.disabled = !up;
  }

  #tell() {
    const names = [...(this.#files.files ?? [])].map(({ name }) => name).join(", ");
    write(this.#chosen, names || t("nav2-card.choose_files"));
  }

  async #send() {
    const [name, files] = [this.#name.value.trim(), this.#files.files];
    if (!name || !files?.length) {
      this.#trouble.say(t("nav2-card.files_and_a_name_are_needed"));
      return;
    }
    this.#take.disabled = true;
    await this.#trouble.attempt(async () => {
      this.session.announce(await this.#taken(name, files));
      this.#form.reset();
      this.#tell();
    });
    this.#take.disabled = false;
  }

  /** @param {string} name @param {FileList} files @returns {Promise<string>} */
  async #taken(name, files) {
    const as = this.#as.value;
    if (as === "map") {
      const kept = await takeInMap(name, files);
      return `${t("nav2-card.the_map_name_is_kept", { name: kept.name })} ${inLanguage(kept.remark)}`.trim();
    }
    const [type = 1, base = 100, multiplier = -1] = as === "keep_out" ? [] : as.split(" ").map(Number);
    const kind = as === "keep_out" ? "keep_out" : "slow";
    const { zones, left_out: rest } = await takeInMask(name, files, {
      kind,
      type: type === 2 ? 2 : 1,
      base,
      multiplier,
    });
    return `${t("nav2-card.count_zones_were_drawn", { count: zones.length })} ${inLanguage(rest)}`.trim();
  }
}

customElements.define("nav2-card", Nav2Card);
