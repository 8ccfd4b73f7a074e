// Element <progress-card>: present precision, goal and progress bar.
// Element <uploads-card>: result of each uploaded file.
// Element <empty-stage>: the reason why there is no picture, and a button that helps.
// Element <camera-choice>: select one of several cameras of this device.

import { icon, isNew, make, mark, write } from "../ui/element.js";
import { remember, remembered } from "../ui/local-storage.js";
import { meter } from "../ui/meter.js";
import { inLanguage, t } from "../ui/texts.js";
import { figures, share } from "./progress.js";
import { grouped } from "./uploads.js";

/** @import { Calibration } from "./types.js" */
/** @import { Uploads } from "./uploads.js" */
/** @import { Webcam } from "./webcam.js" */

export class ProgressCard extends HTMLElement {
  #figure = make("span.progress-figure");
  #goal = make("span.progress-goal");
  #bar = meter("div.meter.progress-bar", { role: "progressbar", "aria-label": t("progress-card.how_far") });
  #words = make("p.progress-words");
  #solving = make("p.progress-solving.note", icon("running"), make("span"));
  #title = make("h2.card-title");

  connectedCallback() {
    if (this.children.length) return;
    this.classList.add("card");
    this.append(
      make("div.progress-head", this.#title, this.#solving),
      make("p.progress-figures", this.#figure, this.#goal),
      this.#bar.element,
      this.#words,
    );
  }

  /** @param {Calibration} calibration */
  show(calibration) {
    const { progress, solving, kind } = calibration;
    const { figure, goal } = figures(calibration);
    write(this.#title, kind === "camera" ? t("progress-card.how_exact") : t("progress-card.how_far"));
    write(this.#figure, figure);
    write(this.#goal, goal);
    write(this.#words, inLanguage(progress.words));
    this.#bar.set(share(calibration));
    mark(this.#bar.element, "aria-valuetext", inLanguage(progress.words));
    mark(this, "data-ready", progress.ready);
    mark(this.#solving, "data-on", solving !== null);
    write(/** @type {Element} */ (this.#solving.lastElementChild), solving ? inLanguage(solving.words) : "");
  }
}

customElements.define("progress-card", ProgressCard);

const NAMED_FILES = 3; // of a row; more are counted

const ICONS = /** @type {Readonly<Record<string, string>>} */ ({ counted: "done", same: "again", nothing: "eye" });

export class UploadsCard extends HTMLElement {
  #title = make("h2.card-title");
  #list = make("ul.attempts");

  connectedCallback() {
    if (this.children.length) return;
    this.classList.add("card");
    this.append(make("div.card-head", this.#title), this.#list);
  }

  /** @param {Uploads} uploads */
  show({ attempts, waiting }) {
    this.hidden = attempts.length + waiting === 0;
    if (!isNew(this, attempts.length, waiting)) return;
    const taken = attempts.filter(({ kind }) => kind === "counted").length;
    write(
      this.#title,
      waiting
        ? t("uploads-card.waiting_filevalue_to_go", { waiting, value: waiting === 1 ? "" : "s" })
        : t("uploads-card.taken_of_length_files_counted", { taken, length: attempts.length }),
    );
    this.#list.replaceChildren(
      ...grouped(attempts).map(({ names, kind, words }) =>
        make(
          "li.attempt",
          { "data-kind": kind },
          icon(ICONS[kind] ?? "refused"),
          make(
            "span",
            make("span.attempt-name", { title: names.join(", ") }, namesIn(names)),
            make("span.note", words),
          ),
        ),
      ),
    );
  }
}

/** @param {string[]} names newest first */
function namesIn(names) {
  const more = names.length - NAMED_FILES;
  const named = names.slice(0, NAMED_FILES).join(", ");
  return more > 0 ? t("uploads-card.names_and_more", { named, more }) : named;
}

customElements.define("uploads-card", UploadsCard);

export class EmptyStage extends HTMLElement {
  #words = make("p");
  #button = make("button.button.primary.large", { onclick: () => this.pressed() });
  /** @type {() => void} */
  pressed = () => undefined;

  connectedCallback() {
    if (this.children.length) return;
    this.append(this.#words, this.#button);
  }

  /**
   * @param {string} why there is no picture; "" when there is one
   * @param {string} offer what the button says; "" for none
   */
  show(why, offer) {
    this.hidden = why === "";
    write(this.#words, why);
    this.#button.hidden = offer === "";
    write(this.#button, offer);
  }
}

customElements.define("empty-stage", EmptyStage);

export class CameraChoice extends HTMLElement {
  #select = make("select.words.small", { "aria-label": t("camera-choice.which_camera") });
  /** @type {() => void} */
  changed = () => undefined;

  connectedCallback() {
    if (this.children.length) return;
    this.hidden = true;
    this.append(this.#select);
    this.#select.addEventListener("change", () => {
      remember("webcam", this.#select.value);
      this.changed();
    });
  }

  /** The id of the camera that was chosen before; undefined when none was. */
  get chosen() {
    return remembered("webcam", "") || undefined;
  }

  /** @param {Webcam} webcam */
  async show(webcam) {
    const choices = await webcam.choices();
    this.hidden = choices.length < 2;
    this.#select.replaceChildren(...choices.map(({ id, name }) => make("option", { value: id }, name)));
    this.#select.value = choices.find(({ id }) => id === this.chosen)?.id ?? choices[0]?.id ?? "";
  }
}

customElements.define("camera-choice", CameraChoice);
