// Element <live-region>: announcements for screen readers, one sentence at a time, without repeats.

import { make } from "../ui/element.js";
import { Panel } from "../ui/panel.js";

const BREATH_MS = 150; // readers need a change after an empty moment to speak the same place again

class LiveRegion extends Panel {
  #place = make("div.visually-hidden", { role: "status", "aria-live": "polite" });
  /** @type {string[]} */
  #waiting = [];
  #timer = 0;

  /** @override */
  build() {
    this.append(this.#place);
    this.session.on("announcement", (sentence) => {
      if (this.#waiting.at(-1) === sentence) return;
      this.#waiting.push(sentence);
      this.#waiting.splice(0, this.#waiting.length - 4);
      if (!this.#timer) this.#timer = setTimeout(() => this.#speak(), BREATH_MS);
    });
  }

  #speak() {
    this.#place.textContent = this.#waiting.splice(0).join(" ");
    this.#timer = 0;
  }
}

customElements.define("live-region", LiveRegion);
