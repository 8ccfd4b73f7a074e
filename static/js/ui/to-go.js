// How much of a command is left: metres of its way, and the seconds that they will take.

import { fixed, metres } from "./format.js";
import { wayLeft } from "./map-text.js";

/** @import { State } from "../net/messages.js" */

const WINDOW_S = 4; // over which the pace is measured
const LEAST_S = 1; // of motion before which the seconds are those at the speed that is set
const MOVES_M_S = 0.02;
const LONGEST_S = 600;

const AT_CRUISE = ["continue", "stop_at", "follow_wall", "start"]; // turns have no speed, who goes to a person their own

/**
 * The speed at which the running command drives, at most.
 * @param {Pick<State, "command">} state
 * @param {number} cruise [m/s]
 * @returns {number | null} [m/s]; null: none runs, or not at that of the robot
 */
export const commandSpeed = ({ command }, cruise) =>
  command?.state === "running" && AT_CRUISE.includes(command.name) ? cruise : null;

export class ToGo {
  #id = 0; // of the command
  /** @type {Array<{at: number, left: number}>} [s] of the robot's clock; metres, or share of the whole */
  #seen = [];

  /**
   * @param {State} state
   * @param {number} [cruise] [m/s] set for the way
   * @returns {string[]} "0.9 m", "5 s": what is known of the two
   */
  saw({ command, goal, path, pose, stamp_s: at, velocity }, cruise = 0) {
    if (command?.state !== "running" || command.progress === null) return [];
    if (command.id !== this.#id) [this.#id, this.#seen] = [command.id, []];
    const straight = goal ? Math.hypot(goal.x_m - pose.x_m, goal.y_m - pose.y_m) : null;
    const length = straight === null ? null : path.length > 1 ? wayLeft(pose, path) : straight;
    const left = length ?? 1 - command.progress;
    const moves = Math.hypot(velocity.v_m_s, velocity.w_rad_s) > MOVES_M_S;
    const turns = moves && Math.abs(velocity.v_m_s) <= MOVES_M_S;
    if (turns && length !== null)
      this.#seen = []; // it comes no nearer
    else if (at !== this.#seen.at(-1)?.at && (moves || this.#seen.length)) this.#seen.push({ at, left });
    this.#seen = this.#seen.filter((one) => at - one.at <= WINDOW_S);
    const set = length !== null && cruise > 0 ? length / cruise : null;
    const seconds = this.#measures(at) ? this.#seconds(left, at) : set;
    const said = [length === null ? "" : metres(length, 1), seconds === null ? "" : `${fixed(seconds, 0)} s`];
    return said.filter(Boolean);
  }

  /** @param {number} at [s] @returns {boolean} whether it has moved for long enough to measure its pace */
  #measures(at) {
    const [first] = this.#seen;
    return first !== undefined && at - first.at >= LEAST_S;
  }

  /** @param {number} left metres, or share of the whole @param {number} at [s] */
  #seconds(left, at) {
    const [first] = this.#seen;
    if (!first) return null;
    const pace = (first.left - left) / (at - first.at);
    const seconds = pace > 0 ? left / pace : Infinity;
    return seconds <= LONGEST_S ? Math.max(1, seconds) : null;
  }
}
