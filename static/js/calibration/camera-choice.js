// Element <camera-choice>: select one of several cameras of this device.

import { make } from "../ui/element.js";
import { remember, remembered } from "../ui/local-storage.js";
import { t } from "../ui/texts.js";

/** @import { Webcam } from "./webcam.js" */

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
