// Learn an input of a gamepad by pressing it: what was moved, and came back to where it was.

import { t } from "../ui/texts.js";
import { STICKS } from "./gamepad-mapping.js";

/** @import { AxisInput, Pad, PadAction, PadInput } from "./gamepad-mapping.js" */

const MOVED = 0.6; // of an axis, away from where it was
const BACK = 0.3; // an axis that is closer than this to where it was is let go
const GIVE_UP_MS = 5000; // within which what was pressed has to come back

/** @type {Readonly<Record<PadAction, string>>} */
export const PROMPTS = {
  deadman: t("gamepad-learning.press_and_release_the_button_that"),
  stop: t("gamepad-learning.press_and_release_the_button_for"),
  slow: t("gamepad-learning.press_and_release_the_button_that_2"),
  slower: t("gamepad-learning.press_and_release_the_button_that_3"),
  faster: t("gamepad-learning.press_and_release_the_button_that_4"),
  talk: t("gamepad-learning.press_and_release_the_button_to_talk"),
  forward: t("gamepad-learning.push_the_stick_fully_forward_then"),
  left: t("gamepad-learning.push_the_stick_fully_to_the"),
};

/** One action that waits for its input. */
export class InputLearner {
  /** @type {readonly number[] | null} */
  #rest = null;
  /** @type {PadInput | null} */
  #found = null;
  #foundAt = 0;

  /** @param {PadAction} action */
  constructor(action) {
    this.action = action;
  }

  /** A sentence: what the operator does next. */
  get prompt() {
    if (!this.#rest) return t("gamepad-learning.let_go_of_every_button_and");
    return this.#found ? t("gamepad-learning.now_let_it_go") : PROMPTS[this.action];
  }

  /**
   * @param {Pad} pad
   * @param {number} now [ms]
   * @returns {{input: PadInput | null, failed: boolean}} the input once it was moved and let go; `failed` when it stays
   */
  take(pad, now) {
    const found = this.#found;
    if (!this.#rest) {
      if (!pad.buttons.some(({ pressed }) => pressed)) this.#rest = [...pad.axes];
    } else if (!found) {
      this.#found = this.#moved(pad, this.#rest);
      this.#foundAt = now;
    } else if (isBack(pad, found, this.#rest)) {
      return { input: found, failed: false };
    } else if (now - this.#foundAt > GIVE_UP_MS) {
      return { input: null, failed: true };
    }
    return { input: null, failed: false };
  }

  /** @param {Pad} pad @param {readonly number[]} rest @returns {PadInput | null} */
  #moved(pad, rest) {
    const button = pad.buttons.findIndex(({ pressed }) => pressed);
    const isStick = STICKS.some((each) => each === this.action);
    if (button >= 0 && !isStick) return { button };
    const [farthest] = pad.axes
      .map((value, axis) => ({ axis, from: rest[axis] ?? NaN, way: value - (rest[axis] ?? NaN) }))
      .filter(
        ({ from, way }) => Math.abs(way) > MOVED && Math.abs(from - Math.round(from)) < BACK && Math.abs(from) < 1.3,
      )
      .sort((one, other) => Math.abs(other.way) - Math.abs(one.way));
    if (!farthest) return null;
    const [sign, at] = [Math.sign(farthest.way), Math.round(farthest.from)];
    return /** @type {AxisInput} */ ({ axis: farthest.axis, sign, rest: at === 0 ? 0 : at });
  }
}

/** @param {Pad} pad @param {PadInput} input @param {readonly number[]} rest */
function isBack(pad, input, rest) {
  if ("button" in input) return pad.buttons[input.button]?.pressed !== true;
  return Math.abs((pad.axes[input.axis] ?? NaN) - (rest[input.axis] ?? NaN)) < BACK;
}
