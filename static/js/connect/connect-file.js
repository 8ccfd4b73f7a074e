// Element <connect-file>: write the robot file, and how to start with it.

import { icon, make, mark, onSubmit, write } from "../ui/element.js";
import { PagePanel } from "../ui/panel.js";
import { t } from "../ui/texts.js";
import { fileOf } from "./connection-model.js";

/** @import { ConnectSensors } from "./connect-sensors.js" */
/** @import { ConnectionModel } from "./connection-model.js" */

const COPIED_MS = 2000;

/** @extends {PagePanel<ConnectionModel>} */
class ConnectFile extends PagePanel {
  #name = make("input.field-box.connect-input", {
    id: "connect-name",
    maxlength: "60",
    autocomplete: "off",
    required: true,
  });
  #writeWords = make("span", t("connect-file.write_robot_file"));
  #write = make("button.button.primary.large", { type: "submit" }, icon("save"), this.#writeWords);
  #why = make("p.note", { role: "status" });
  #question = make("p");
  #replace = make("button.button.primary", { onclick: () => void this.#send(true) }, t("connect-file.replace_it"));
  #keep = make("button.button", t("connect-file.keep_it"));
  #asks = make("div.row.connect-asks", { hidden: true }, this.#question, this.#replace, this.#keep);
  #command = make("code.connect-command", { tabindex: "0" });
  #copyWords = make("span", t("connect-file.copy"));
  #copy = make("button.button", { onclick: () => void this.#take() }, this.#copyWords);
  #path = make("p");
  #text = make("pre.connect-text", { tabindex: "0" });
  #done = make(
    "div.connect-done",
    { hidden: true },
    this.#path,
    make("p.note", t("connect-file.start_the_console_with_it")),
    make("div.connect-line", this.#command, this.#copy),
    make("details", make("summary", t("connect-file.what_it_says")), this.#text),
  );
  #form = make("form.connect-form");
  #filled = "";

  /** @override */
  build() {
    this.#form.append(
      make("label", { for: "connect-name" }, t("connect-file.name_of_the_robot")),
      this.#name,
      this.#write,
    );
    this.append(
      make(
        "section.card.page-card",
        { "aria-label": t("connect-file.robot_file") },
        make("h2", t("connect-file.robot_file")),
        make("p", t("connect-file.keeps_what_stands_here_so_that")),
        this.#form,
        this.#why,
        this.#asks,
        this.#done,
      ),
    );
    onSubmit(this.#form, () => this.#begin());
    this.#name.addEventListener("input", () => this.draw());
    this.#keep.addEventListener("click", () => {
      this.#asks.hidden = true;
      this.#name.focus();
    });
    this.draw();
  }

  #begin() {
    const file = fileOf(this.#name.value);
    if (this.model.files.includes(file)) {
      write(this.#question, t("connect-file.there_is_a_file_already_replace", { file }));
      this.#asks.hidden = false;
      this.#keep.focus();
    } else void this.#send(false);
  }

  /** @param {boolean} replace */
  async #send(replace) {
    this.#asks.hidden = true;
    const sensors = /** @type {ConnectSensors | null} */ (document.querySelector("connect-sensors"));
    const confirmed = sensors?.confirmed;
    if (confirmed) await this.model.write({ ...confirmed, name: this.#name.value.trim() }, replace);
    else write(this.#why, t("connect-file.one_of_the_values_above_is"));
  }

  async #take() {
    const text = this.#command.textContent ?? "";
    try {
      await navigator.clipboard.writeText(text);
      write(this.#copyWords, t("connect-file.copied"));
    } catch {
      getSelection()?.selectAllChildren(this.#command); // a page without TLS may not write there
      write(this.#copyWords, t("connect-file.press_ctrl_c"));
    }
    setTimeout(() => write(this.#copyWords, t("connect-file.copy")), COPIED_MS);
  }

  /** @override */
  draw() {
    const model = this.model;
    const { found, written } = model;
    if (found && this.#filled !== found.url) {
      this.#filled = found.url;
      this.#name.value = found.name;
    }
    const why = model.whyNot || (model.changed ? t("connect-file.look_again_first_other_topics_are") : "");
    this.#form.hidden = Boolean(model.whyNot);
    this.#write.disabled = !found || !model.may || Boolean(model.busy) || Boolean(why);
    this.#name.disabled = !model.may;
    write(
      this.#why,
      why ||
        (this.#name.value.trim()
          ? t("connect-file.becomes_fileof_in_the_data_folder", { fileof: fileOf(this.#name.value) })
          : ""),
    );
    this.#done.hidden = !written;
    mark(this, "data-written", written !== null);
    if (!written) return;
    write(this.#path, t("connect-file.path_is_written", { path: written.path }));
    write(this.#command, written.command);
    write(this.#text, written.text);
  }
}

customElements.define("connect-file", ConnectFile);
