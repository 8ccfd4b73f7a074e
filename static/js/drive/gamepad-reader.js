// Hold-to-drive by gamepad: which gamepad drives, and what takes it out of the operator's hands. Time is injected.

import { t } from "../ui/texts.js";
import { isComplete, isPressed, stickVelocity } from "./gamepad-mapping.js";
import { inputName } from "./gamepad-names.js";

/** @import { Mapping, Pad } from "./gamepad-mapping.js" */
/** @import { Velocity } from "./keys.js" */
/**
 * @typedef {object} Reading
 * @property {Velocity} velocity zero unless a deadman is held
 * @property {boolean} slow
 * @property {boolean} stop a STOP button went down
 * @property {number} steps by which the speed preset changes
 * @property {boolean} talk the button to talk is held
 */

export const FROZEN_MS = 300; // one timestamp for longer than that, while the deadman is held: the gamepad is frozen
/** A browser that reports a gamepad on change only repeats the timestamp of a steady hand, too. */
export const FROZEN_ON_CHANGE_MS = 1000;
/** A gamepad that has just been connected may look let go until its first report. */
export const SETTLE_MS = 200;

const STILL = { v: 0, w: 0 };

/** What is remembered of one gamepad from one reading to the next. */
class PadMemory {
  #timestamp = NaN;
  #values = "";
  #freshAt = 0;
  #streams = false; // was seen to report the same values with a newer timestamp
  #onChange = false; // was seen silent, let go, until a value changed
  /** @type {Set<string>} */
  #down = new Set();
  rested = false; // deadman up and sticks centred, since the last trip
  held = false;

  /** @param {number} now [ms] */
  constructor(now) {
    this.connectedAt = now;
  }

  /** @param {Pad} pad @param {number} now [ms] */
  take(pad, now) {
    if (pad.timestamp === this.#timestamp) return;
    const values = JSON.stringify([pad.axes, pad.buttons.map(({ pressed, value }) => [pressed, value])]);
    if (values === this.#values) this.#streams = true;
    else if (!this.held && this.#values && now - this.#freshAt > FROZEN_MS) this.#onChange = true;
    this.#timestamp = pad.timestamp;
    this.#values = values;
    this.#freshAt = now;
  }

  /** @param {number} now [ms] */
  isFrozen(now) {
    return now - this.#freshAt > (this.#onChange && !this.#streams ? FROZEN_ON_CHANGE_MS : FROZEN_MS);
  }

  /** True when a button goes down. @param {string} action @param {boolean} pressed */
  goesDown(action, pressed) {
    const before = this.#down.has(action);
    if (pressed) this.#down.add(action);
    else this.#down.delete(action);
    return pressed && !before;
  }
}

export class GamepadReader {
  /** @type {Map<number, PadMemory>} */
  #memories = new Map();
  /** @type {number | null} */
  #active = null;
  #why = "";

  /** Index of the gamepad that drives: its deadman is held. */
  get active() {
    return this.#active;
  }

  /** The reason when a deadman is held and nothing moves, else "". */
  get why() {
    return this.#why;
  }

  /** Zero until every deadman was released and its sticks were centred. @param {string} why a sentence */
  trip(why) {
    const held = [...this.#memories.values()].some((memory) => memory.held);
    for (const memory of this.#memories.values()) memory.rested = false;
    this.#active = null;
    this.#why = held ? why : "";
  }

  /**
   * @param {readonly Pad[]} pads that are connected
   * @param {(pad: Pad) => Mapping} mappingOf
   * @param {number} now [ms]
   * @param {string} [blocked] a sentence when gamepads must not drive now
   * @returns {Reading}
   */
  read(pads, mappingOf, now, blocked = "") {
    this.#forget(pads);
    /** @type {Reading} */
    const reading = { velocity: STILL, slow: false, stop: false, steps: 0, talk: false };
    for (const pad of pads) this.#take(pad, mappingOf(pad), now, reading);
    if (blocked) {
      this.trip(blocked);
      return { ...reading, steps: 0, talk: false };
    }
    const pad = pads.find(({ index }) => index === this.#active);
    if (!pad) return reading;
    const mapping = mappingOf(pad);
    if (this.#memories.get(pad.index)?.isFrozen(now)) {
      this.trip(t("gamepad-reader.the_gamepad_sent_nothing_new_release", { deadmanname: deadmanName(pad, mapping) }));
      return reading;
    }
    return { ...reading, velocity: stickVelocity(pad, mapping), slow: isPressed(pad, mapping.inputs.slow) };
  }

  /** @param {readonly Pad[]} pads */
  #forget(pads) {
    for (const index of this.#memories.keys()) {
      if (!pads.some((pad) => pad.index === index)) this.#memories.delete(index);
    }
    if (this.#active !== null && !this.#memories.has(this.#active)) this.#active = null;
    if (![...this.#memories.values()].some((memory) => memory.held)) this.#why = "";
  }

  /**
   * @param {Pad} pad
   * @param {Mapping} mapping
   * @param {number} now
   * @param {Reading} reading
   */
  #take(pad, mapping, now, reading) {
    const memory = this.#memories.get(pad.index) ?? new PadMemory(now);
    this.#memories.set(pad.index, memory);
    memory.take(pad, now);
    const { inputs } = mapping;
    if (memory.goesDown("stop", isPressed(pad, inputs.stop))) reading.stop = true;
    if (memory.goesDown("slower", isPressed(pad, inputs.slower))) reading.steps -= 1;
    if (memory.goesDown("faster", isPressed(pad, inputs.faster))) reading.steps += 1;
    if (isPressed(pad, inputs.talk)) reading.talk = true;
    memory.held = isPressed(pad, inputs.deadman);
    if (memory.held) this.#hold(pad, mapping, memory);
    else this.#release(pad, mapping, memory, now);
  }

  /** @param {Pad} pad @param {Mapping} mapping @param {PadMemory} memory */
  #hold(pad, mapping, memory) {
    const name = deadmanName(pad, mapping);
    if (this.#active === pad.index) return;
    if (this.#active !== null) {
      memory.rested = false; // its deadman has to be pressed after the other one was released
    } else if (!isComplete(mapping)) {
      this.#why = t("gamepad-reader.set_this_gamepad_up_first_menu");
    } else if (memory.rested) {
      this.#active = pad.index;
      this.#why = "";
    } else if (!this.#why) {
      this.#why = t("gamepad-reader.release_name_and_let_the_stick", { name, name2: name });
    }
  }

  /**
   * @param {Pad} pad
   * @param {Mapping} mapping
   * @param {PadMemory} memory
   * @param {number} now
   */
  #release(pad, mapping, memory, now) {
    if (this.#active === pad.index) this.#active = null;
    const { v, w } = stickVelocity(pad, mapping);
    if (v === 0 && w === 0 && now - memory.connectedAt >= SETTLE_MS) memory.rested = true;
  }
}

/** @param {Pad} pad @param {Mapping} mapping */
const deadmanName = (pad, { inputs }) =>
  inputs.deadman ? inputName(pad, inputs.deadman) : t("gamepad-reader.the_button");
