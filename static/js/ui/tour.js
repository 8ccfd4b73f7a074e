// A tour: steps one after another, each for as long as it takes, until it is ended.

/**
 * @typedef {object} Stop a step of the tour
 * @property {string} title
 * @property {string} text
 * @property {string} at selector of what it shows, which its card leaves free
 * @property {(tour: Tour) => Promise<unknown>} act what happens, until it has
 */

const LOOK_MS = 100;
const READ_MS = 2500; // a step is shown at least
const PATIENCE_MS = 30000; // for what a step waits for

export class Tour {
  over = false;
  #steps;
  #show;
  /** @type {Set<() => void>} */
  #waiting = new Set();

  /** @param {Stop[]} steps @param {(step: Stop, index: number, count: number) => void} show */
  constructor(steps, show) {
    this.#steps = steps;
    this.#show = show;
  }

  /** @returns {Promise<boolean>} whether it came to its end */
  async run() {
    for (const [index, step] of this.#steps.entries()) {
      if (this.over) return false;
      this.#show(step, index, this.#steps.length);
      const read = this.pause(READ_MS);
      try {
        await step.act(this);
      } catch {
        this.end(); // the link is gone, or someone else drives: both are said elsewhere
      }
      await read;
    }
    return !this.over;
  }

  /** End it: nothing of it waits any more. */
  end() {
    this.over = true;
    for (const go of this.#waiting) go();
  }

  /** @param {number} ms at most: the end of the tour ends it */
  pause(ms) {
    return new Promise((resolve) => {
      const go = () => {
        clearTimeout(timer);
        this.#waiting.delete(go);
        resolve(undefined);
      };
      const timer = setTimeout(go, this.over ? 0 : ms);
      this.#waiting.add(go);
    });
  }

  /**
   * @param {() => boolean | Promise<boolean>} isSo waited for, with patience
   * @returns {Promise<boolean>} whether it is
   */
  async until(isSo) {
    for (let waited = 0; waited < PATIENCE_MS && !this.over; waited += LOOK_MS) {
      if (await isSo()) return true;
      await this.pause(LOOK_MS);
    }
    return false;
  }
}
