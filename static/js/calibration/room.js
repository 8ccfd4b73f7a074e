// One room of the wizards: built once, shown while the address says so.

import { Panel } from "../panel.js";

/** @typedef {import("./bench.js").Bench} Bench */

export class Room extends Panel {
  /** @type {Bench | null} */
  #bench = null;

  /** @returns {Bench} */
  get bench() {
    if (!this.#bench) throw new Error(`<${this.localName}> was used before it was given a workbench.`);
    return this.#bench;
  }

  /** @param {Bench} bench */
  enter(bench) {
    this.#bench = bench;
    this.join(bench.session);
  }

  /** Called when this room is opened. */
  opened() {}

  /** Called when another room is opened. */
  left() {}

  /** Called while it is open, whenever something changed and at least five times a second. */
  draw() {}
}
