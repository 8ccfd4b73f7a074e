// Element <connect-file>: write the robot file, and how to start with it.

import { icon, make, mark, write } from "../ui/element.js";
import { Panel } from "../ui/panel.js";
import { fileOf } from "./connection-model.js";

/** @typedef {import("./connection-model.js").ConnectionModel} ConnectionModel */
/** @typedef {import("./connect-sensors.js").ConnectSensors} ConnectSensors */

const COPIED_MS = 2000;

class ConnectFile extends Panel {
  /** @type {ConnectionModel | null} */
  #model = null;
  #name = make("input", {
    id: "connect-name",
    class: "connect-input",
    maxlength: "60",
    autocomplete: "off",
    required: true,
  });
  #writeWords = make("span", {}, "Write robot file");
  #write = make("button", { type: "submit", class: "button primary large" }, icon("save"), this.#writeWords);
  #why = make("p", { class: "note", role: "status" });
  #question = make("p", {});
  #replace = make("button", { type: "button", class: "button primary" }, "Replace it");
  #keep = make("button", { type: "button", class: "button" }, "Keep it");
  #asks = make("div", { class: "connect-asks", hidden: true }, this.#question, this.#replace, this.#keep);
  #command = make("code", { class: "connect-command", tabindex: "0" });
  #copyWords = make("span", {}, "Copy");
  #copy = make("button", { type: "button", class: "button" }, this.#copyWords);
  #path = make("p", {});
  #text = make("pre", { class: "connect-text", tabindex: "0" });
  #done = make(
    "div",
    { class: "connect-done", hidden: true },
    this.#path,
    make("p", { class: "note" }, "Start the console with it:"),
    make("div", { class: "connect-line" }, this.#command, this.#copy),
    make("details", {}, make("summary", {}, "What it says"), this.#text),
  );
  #form = make("form", { class: "connect-form" });
  #filled = "";

  /** @param {ConnectionModel} model */
  watch(model) {
    this.#model = model;
    model.onChange(() => this.#draw());
  }

  /** @override */
  build() {
    this.#form.append(make("label", { for: "connect-name" }, "Name of the robot"), this.#name, this.#write);
    this.append(
      make(
        "section",
        { class: "card connect-card", "aria-label": "Robot file" },
        make("h2", {}, "Robot file"),
        make("p", {}, "Keeps what stands here, so that nothing is guessed at the next start."),
        this.#form,
        this.#why,
        this.#asks,
        this.#done,
      ),
    );
    this.#form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.#begin();
    });
    this.#name.addEventListener("input", () => this.#draw());
    this.#replace.addEventListener("click", () => void this.#send(true));
    this.#keep.addEventListener("click", () => {
      this.#asks.hidden = true;
      this.#name.focus();
    });
    this.#copy.addEventListener("click", () => void this.#take());
    this.#draw();
  }

  #begin() {
    const file = fileOf(this.#name.value);
    if (this.#model?.files.includes(file)) {
      write(this.#question, `There is a ${file} already. Replace it?`);
      this.#asks.hidden = false;
      this.#keep.focus();
    } else void this.#send(false);
  }

  /** @param {boolean} replace */
  async #send(replace) {
    this.#asks.hidden = true;
    const sensors = /** @type {ConnectSensors | null} */ (document.querySelector("connect-sensors"));
    const confirmed = sensors?.confirmed;
    if (confirmed) await this.#model?.write({ ...confirmed, name: this.#name.value.trim() }, replace);
    else write(this.#why, "One of the values above is not a number.");
  }

  async #take() {
    const text = this.#command.textContent ?? "";
    try {
      await navigator.clipboard.writeText(text);
      write(this.#copyWords, "Copied");
    } catch {
      getSelection()?.selectAllChildren(this.#command); // a page without TLS may not write there
      write(this.#copyWords, "Press Ctrl+C");
    }
    setTimeout(() => write(this.#copyWords, "Copy"), COPIED_MS);
  }

  #draw() {
    const model = this.#model;
    if (!model) return;
    const { found, written } = model;
    if (found && this.#filled !== found.url) {
      this.#filled = found.url;
      this.#name.value = found.name;
    }
    const why = model.whyNot || (model.changed ? "Look again first: other topics are chosen." : "");
    this.#form.hidden = Boolean(model.whyNot);
    this.#write.disabled = !found || !model.may || Boolean(model.busy) || Boolean(why);
    this.#name.disabled = !model.may;
    write(this.#why, why || (this.#name.value.trim() ? `Becomes ${fileOf(this.#name.value)} in the data folder.` : ""));
    this.#done.hidden = !written;
    mark(this, "data-written", written !== null);
    if (!written) return;
    write(this.#path, `${written.path} is written.`);
    write(this.#command, written.command);
    write(this.#text, written.text);
  }
}

customElements.define("connect-file", ConnectFile);
