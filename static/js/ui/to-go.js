// How much of a command is left: metres of its way, and the seconds that they will take.

import { fixed, metres } from "./format.js";
import { wayLeft } from "./map-text.js";

/** @typedef {import("../net/messages.js").State} State */

const WINDOW_S = 4; // over which the pace is measured
const LEAST_S = 1; // of measuring, before which no seconds are shown
const LONGEST_S = 600;

export class ToGo {
  #id = 0; // of the command
  /** @type {Array<{at: number, left: number}>} [s] of the robot's clock; metres, or share of the whole */
  #seen = [];

  /**
   * @param {State} state
   * @returns {string[]} "0.9 m", "5 s": what is known of the two
   */
  saw({ command, goal, path, pose, stamp_s: at }) {
    if (command?.state !== "running" || command.progress === null) return [];
    if (command.id !== this.#id) [this.#id, this.#seen] = [command.id, []];
    const straight = goal ? Math.hypot(goal.x_m - pose.x_m, goal.y_m - pose.y_m) : null;
    const length = straight === null ? null : path.length > 1 ? wayLeft(pose, path) : straight;
    const left = length ?? 1 - command.progress;
    if (at !== this.#seen.at(-1)?.at) this.#seen.push({ at, left });
    this.#seen = this.#seen.filter((one) => at - one.at <= WINDOW_S);
    const seconds = this.#seconds(left, at);
    const said = [length === null ? "" : metres(length, 1), seconds === null ? "" : `${fixed(seconds, 0)} s`];
    return said.filter(Boolean);
  }

  /**
   * @param {number} left metres, or share of the whole
   * @param {number} at [s]
   */
  #seconds(left, at) {
    const [first] = this.#seen;
    if (!first || at - first.at < LEAST_S) return null;
    const pace = (first.left - left) / (at - first.at);
    const seconds = pace > 0 ? left / pace : Infinity;
    return seconds <= LONGEST_S ? Math.max(1, seconds) : null;
  }
}
