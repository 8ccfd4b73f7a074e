// What a driver reads off the large camera picture without looking away: heading, speed, how far it is to what stands ahead.

import { make, write } from "./element.js";
import { degrees, fixed } from "./format.js";
import { t } from "./texts.js";

const AHEAD_SHARE = 0.06; // of the picture's width on each side of its middle
const SEEN_S = 1.5; // that a distance is shown: a robot at rest sends the laser less often
const TURN_DEG = 360;
const MARK_DEG = 30;
const MARK_PX = 84; // between two of them on the tape

export class HeadUp {
  #heading = make("span.head-up-heading");
  #tape = make("div.head-up-tape");
  #speed = make("span.head-up-value");
  #ahead = make("span.head-up-value");
  #seen = "–";
  #seenAt = -Infinity; // [s] of the robot's clock

  element = make(
    "div.head-up",
    make("div.head-up-top", this.#tape, this.#heading),
    make("span.head-up-cross"),
    figure("speed", this.#speed, "m/s", t("head-up.speed")),
    figure("ahead", this.#ahead, "m", t("head-up.ahead")),
  );

  constructor() {
    for (let mark = -TURN_DEG; mark <= TURN_DEG; mark += MARK_DEG) {
      const words = String((TURN_DEG - mark) % TURN_DEG); // to the left is more: counter-clockwise
      const at = `calc(50% + ${(mark / MARK_DEG) * MARK_PX}px)`;
      const part = make("span.head-up-mark", { "aria-hidden": "true" }, words);
      part.style.left = at;
      this.#tape.append(part);
    }
  }

  /** @param {import("../net/messages.js").State} state @param {boolean} up */
  show({ stamp_s: stamp, pose, velocity, camera }, up) {
    const heading = ((((pose.heading_rad * 180) / Math.PI) % TURN_DEG) + TURN_DEG) % TURN_DEG;
    write(this.#heading, degrees(pose.heading_rad, 0));
    this.#tape.style.translate = `${((heading > TURN_DEG / 2 ? heading - TURN_DEG : heading) / MARK_DEG) * MARK_PX}px 0`;
    write(this.#speed, fixed(velocity.v_m_s, 2));
    const ahead = up && camera ? nearest(camera) : Infinity;
    if (ahead < Infinity) [this.#seen, this.#seenAt] = [fixed(ahead, 2), stamp];
    write(this.#ahead, stamp - this.#seenAt < SEEN_S ? this.#seen : "–");
  }
}

/** @param {import("../net/messages.js").CameraOverlay} camera @returns {number} [m], Infinity for nothing */
function nearest({ laser, width }) {
  const ahead = laser.filter(([u]) => Math.abs(u - width / 2) < AHEAD_SHARE * width);
  return Math.min(...ahead.map(([, , range]) => range));
}

/**
 * @param {string} name
 * @param {Element} value
 * @param {string} unit
 * @param {string} says
 */
function figure(name, value, unit, says) {
  const words = make("span.head-up-name", says);
  return make("div.head-up-figure", { "data-name": name }, words, make("span", value, ` ${unit}`));
}
