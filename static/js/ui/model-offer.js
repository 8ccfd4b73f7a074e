// The offer of a model that is not here yet: what works now, and a button that fetches the better one.

import { make, write } from "./element.js";
import { inLanguage, t } from "./texts.js";

/** @typedef {{active: string, installed: boolean, megabytes: number, gives: string, licence: string}} Offered */

export class ModelOffer {
  #says = make("p.note");
  #button = make("button.button.primary", { hidden: true, onclick: () => void this.#get() });
  /** @type {() => Promise<Offered>} */
  #read;
  /** @type {() => Promise<unknown>} */
  #fetch;
  /** @type {(act: () => Promise<unknown>) => Promise<unknown>} */
  #attempt;

  /**
   * @param {() => Promise<Offered>} read
   * @param {() => Promise<unknown>} fetch the model; it takes as long as the download
   * @param {(act: () => Promise<unknown>) => Promise<unknown>} attempt a call, whose failure is shown
   */
  constructor(read, fetch, attempt) {
    this.#read = read;
    this.#fetch = fetch;
    this.#attempt = attempt;
  }

  get elements() {
    return [this.#says, this.#button];
  }

  async show() {
    await this.#attempt(async () => {
      const { active, installed, megabytes, gives, licence } = await this.#read();
      write(this.#says, inLanguage(active));
      write(this.#button, t("model-offer.gives_megabytes_mb", { gives: inLanguage(gives), megabytes }));
      this.#button.title = licence;
      this.#button.hidden = installed;
    });
  }

  async #get() {
    this.#button.disabled = true;
    write(this.#button, t("model-offer.fetching_the_model"));
    await this.#attempt(this.#fetch);
    this.#button.disabled = false;
    await this.show();
  }
}
