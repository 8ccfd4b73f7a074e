// Element <empty-stage>: the reason why there is no picture, and a button that helps.

import { make, write } from "../ui/element.js";

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
