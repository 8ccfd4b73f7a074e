// Base class of the dialogs that name something on the map and save it.

import { make, nameField, onSubmit } from "./element.js";
import { Sheet } from "./sheet.js";
import { t } from "./texts.js";
import { TroubleLine } from "./trouble-line.js";

export class NameSheet extends Sheet {
  #name = nameField("", { id: "" });
  #trouble = new TroubleLine();
  #keep = make("button.button.primary", { type: "submit" }, t("place-sheet.save"));

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
    await this.#trouble.attempt(async () => {
      this.session.announce(await this.save(name));
      this.shut();
    }, this.#keep);
  }
}
