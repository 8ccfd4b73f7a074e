// Hold to drive: from what the hands ask for to frames for the gate. No clock, no page: time and sending are given.

/** @typedef {import("./keys.js").Wish} Wish */
/** @typedef {{v: number, w: number, press: number, seq: number, nonce: number, epoch: number}} DriveFrame */
/**
 * @typedef {object} Permission may we drive, and if not, why not
 * @property {"yes" | "ask" | "no"} may "ask": nobody drives, the wheel is ours for the asking
 * @property {string} why a sentence when the answer is no
 */

export const PERIOD_MS = 50; // 20 frames a second while a hand is on it
export const LATE_MS = 250; // a page that was busy for longer has lost touch: the hands must let go first
export const ZEROS = 3; // then silence, so that we never fight a plan
export const ASK_MS = 1500; // how long a press may wait for the lease it asked for
export const NEUTRAL_MS = 800; // how long the gate may need to see our zero before the press counts as refused

/** Speed presets 1 to 5 as parts of the robot's limits. */
export const PRESETS = [0.2, 0.4, 0.6, 0.8, 1];
export const SLOW = 0.35; // Shift

export class Drive {
  /** @type {Wish} */
  #keys = { v: 0, w: 0 };
  /** @type {Wish} */
  #stick = { v: 0, w: 0 };
  /** @type {Permission} */
  #permission = { may: "no", why: "The page is not connected yet." };
  #gate = { nonce: 0, epoch: 0, needNeutral: false };
  #engaged = false;
  #neutralSeen = true; // has the gate been without a wish for neutral at some time of this press?
  #engagedAt = 0;
  #asking = -Infinity;
  #mustLetGo = false;
  #why = "";
  #press = 0;
  #seq = 0;
  #zeros = 0;
  #sentAt = 0;
  preset = 3;
  slow = false;
  limits = { speed: 0, turnRate: 0 };

  /**
   * @param {object} world
   * @param {(frame: DriveFrame) => void} world.send
   * @param {() => void} world.ask asks the server for the lease
   * @param {() => number} world.draw a number for a new press, never the same twice
   * @param {() => number} world.count rises over reloads and tabs, so that no frame looks older than one sent before:
   *   the console's steady clock in milliseconds
   */
  constructor({ send, ask, draw, count }) {
    this.send = send;
    this.ask = ask;
    this.draw = draw;
    this.count = count;
  }

  get engaged() {
    return this.#engaged;
  }

  /** A sentence when the hands are on it and nothing moves, else "". */
  get why() {
    return this.#why;
  }

  get mustLetGo() {
    return this.#mustLetGo;
  }

  /** @returns {Wish} what the hands ask for now */
  get wish() {
    /** @param {number} a @param {number} b */
    const stronger = (a, b) => (Math.abs(a) >= Math.abs(b) ? a : b);
    return { v: stronger(this.#keys.v, this.#stick.v), w: stronger(this.#keys.w, this.#stick.w) };
  }

  /** @returns {{v: number, w: number}} [m/s], [rad/s] what a frame sent now would ask for */
  get order() {
    const scale = (PRESETS[this.preset - 1] ?? 0.6) * (this.slow ? SLOW : 1);
    const { v, w } = this.wish;
    return { v: v * scale * this.limits.speed, w: w * scale * this.limits.turnRate };
  }

  /**
   * @param {Wish} wish
   * @param {number} now [ms]
   */
  keys(wish, now) {
    this.#keys = wish;
    this.#follow(now, true);
  }

  /**
   * @param {Wish} wish
   * @param {number} now [ms]
   */
  stick(wish, now) {
    this.#stick = wish;
    this.#follow(now, false);
  }

  /**
   * What the newest state says about the gate and about us.
   * @param {{nonce: number, epoch: number, needNeutral: boolean}} gate
   * @param {Permission} permission
   * @param {number} now [ms]
   */
  hear(gate, permission, now) {
    const changedHands = gate.epoch !== this.#gate.epoch;
    this.#gate = gate;
    this.#permission = permission;
    if (!this.#engaged) {
      if (this.#mustLetGo && permission.may === "no") this.#why = permission.why || this.#why;
      this.#await(now);
      return;
    }
    if (permission.may !== "yes") this.trip(permission.why || "You no longer drive.");
    else if (changedHands) this.trip("The wheel changed hands.");
    else if (!gate.needNeutral) this.#neutralSeen = true;
    else if (this.#neutralSeen) this.trip("The gate stopped the robot.");
    else if (now - this.#engagedAt > NEUTRAL_MS) this.trip("The gate did not take this press.");
  }

  /**
   * Zero now, and nothing more until every key and the stick have been let go.
   * @param {string} why a sentence
   */
  trip(why) {
    this.#asking = -Infinity;
    if (this.#engaged) this.#letGo();
    if (this.#neutral) return;
    this.#mustLetGo = true;
    this.#why = why;
  }

  /** Zero now and forget the hands: the page lost sight of them (blur, hidden, a cancelled pointer). */
  abandon() {
    this.#keys = { v: 0, w: 0 };
    this.#stick = { v: 0, w: 0 };
    this.#asking = -Infinity;
    this.#mustLetGo = false;
    this.#why = "";
    if (this.#engaged) this.#letGo();
  }

  /**
   * Every PERIOD_MS, from the main thread only.
   * @param {number} now [ms]
   */
  tick(now) {
    if (this.#engaged && now - this.#sentAt > LATE_MS) this.trip("The page was busy and lost touch.");
    else if (this.#engaged) this.#order(now);
    else if (this.#zeros > 0) this.#zero();
  }

  get #neutral() {
    const { v, w } = this.wish;
    return v === 0 && w === 0;
  }

  /**
   * @param {number} now
   * @param {boolean} atOnce send a changed wish now (keys) or with the next tick (stick: it changes all the time)
   */
  #follow(now, atOnce) {
    if (this.#neutral) {
      this.#mustLetGo = false;
      this.#why = "";
      this.#asking = -Infinity;
      if (this.#engaged) this.#letGo();
    } else if (this.#engaged) {
      if (atOnce && now - this.#sentAt <= LATE_MS) this.#order(now);
    } else if (!this.#mustLetGo) {
      this.#take(now);
    }
  }

  /**
   * The press has asked for the wheel: drive when it is ours, give up when it does not come.
   * @param {number} now
   */
  #await(now) {
    if (this.#asking === -Infinity) return;
    if (now - this.#asking >= ASK_MS) this.trip("The wheel did not come. Let go, then press again.");
    else if (this.#permission.may === "yes") this.#follow(now, true);
    else if (this.#permission.may === "no") this.trip(this.#permission.why);
  }

  /** @param {number} now */
  #take(now) {
    if (this.#permission.may === "no") {
      this.#mustLetGo = true;
      this.#why = this.#permission.why;
    } else if (this.#permission.may === "ask") {
      if (this.#asking !== -Infinity) return;
      this.#asking = now;
      this.ask();
      this.#frame(0, 0); // a gate that was started anew learns from it who drives
    } else {
      this.#engage(now);
    }
  }

  /** @param {number} now */
  #engage(now) {
    this.#asking = -Infinity;
    this.#engaged = true;
    this.#engagedAt = now;
    this.#press = this.draw();
    this.#neutralSeen = !this.#gate.needNeutral;
    this.#zeros = 0;
    this.#why = "";
    if (this.#gate.needNeutral) {
      this.#frame(0, 0);
      this.#sentAt = now;
    } else {
      this.#order(now);
    }
  }

  #letGo() {
    this.#engaged = false;
    this.#zeros = ZEROS;
    this.#zero();
  }

  #zero() {
    this.#zeros -= 1;
    this.#frame(0, 0);
  }

  /** @param {number} now */
  #order(now) {
    const { v, w } = this.order;
    this.#sentAt = now;
    this.#frame(v, w);
  }

  /**
   * @param {number} v
   * @param {number} w
   */
  #frame(v, w) {
    this.#seq = Math.max(this.#seq + 1, this.count());
    const { nonce, epoch } = this.#gate;
    this.send({ v, w, press: this.#press, seq: this.#seq, nonce, epoch });
  }
}
