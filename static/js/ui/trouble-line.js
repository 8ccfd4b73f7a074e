// The line of a panel that says why something could not be done.

import { sentenceOf } from "../net/api.js";
import { make, mark, write } from "./element.js";
import { t } from "./texts.js";

export class TroubleLine {
  element = make("p.map-trouble", { role: "alert", hidden: true });
  #field;
  #ofRead = ""; // what a read in the background said last

  /** @param {HTMLElement | null} [field] that is marked as wrong meanwhile */
  constructor(field = null) {
    this.#field = field;
  }

  /** @param {string} sentence "": there is no trouble */
  say(sentence) {
    this.element.hidden = !sentence;
    write(this.element, sentence);
    if (this.#field) mark(this.#field, "aria-invalid", sentence ? "true" : null);
  }

  /**
   * Read something in the background and say why it could not be read; what an act of the user's said stays.
   * @param {() => Promise<unknown>} act
   * @returns {Promise<boolean>} whether it could be read
   */
  async read(act) {
    const ours = () => this.element.textContent === this.#ofRead;
    try {
      await act();
      if (ours()) this.say("");
      return true;
    } catch (refusal) {
      if (!ours() && !this.element.hidden) return false;
      this.#ofRead = sentenceOf(refusal);
      this.say(this.#ofRead);
      return false;
    }
  }

  /**
   * Do something and say why it could not be done.
   * @param {() => Promise<unknown>} act
   * @param {HTMLButtonElement} [button] of words alone, which says "Saving…" meanwhile
   * @returns {Promise<boolean>} whether it was done
   */
  async attempt(act, button) {
    const words = button?.textContent ?? "";
    if (button) {
      button.disabled = true;
      write(button, t("trouble-line.saving"));
    }
    try {
      await act();
      this.say("");
      return true;
    } catch (refusal) {
      this.say(sentenceOf(refusal));
      return false;
    } finally {
      if (button) {
        button.disabled = false;
        write(button, words);
      }
    }
  }
}
