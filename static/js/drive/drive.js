// Hold-to-drive logic (the deadman of keys and stick): turns operator input into jog frames for the gate. Time and transport are injected.

import { t } from "../ui/texts.js";

/** @import { Velocity } from "./keys.js" */
/** @typedef {{v: number, w: number, press: number, seq: number, nonce: number, epoch: number}} DriveFrame */
/**
 * @typedef {object} Permission to drive, with the reason if not
 * @property {"yes" | "ask" | "no"} may "ask": nobody has control, it can be requested
 * @property {string} why a sentence when may is "no"
 * @property {boolean} [held] true when only another operator, who has control, stands against it
 */

export const PERIOD_MS = 50; // 20 frames per second while a key or the stick is held
export const LATE_MS = 250; // after a longer pause of the page, every key and the stick must be released first
export const ZEROS = 3; // then silence, so that this page does not interrupt a plan
export const ASK_MS = 1500; // how long a press may wait for the lease it asked for
export const NEUTRAL_MS = 800; // within which the gate must accept a zero, or the press counts as refused

/** Speed presets 1 to 5 as parts of the robot's limits. */
export const PRESETS = [0.2, 0.4, 0.6, 0.8, 1];
export const SLOW = 0.35; // Shift

export class Drive {
  /** @type {Velocity} */
  #keys = { v: 0, w: 0 };
  /** @type {Velocity} */
  #stick = { v: 0, w: 0 };
  /** @type {Velocity} */
  #gamepad = { v: 0, w: 0 };
  /** @type {Permission} */
  #permission = { may: "no", why: t("drive.the_page_is_not_connected_yet") };
  #gate = { nonce: 0, epoch: 0, needNeutral: false };
  #engaged = false;
  #neutralSeen = true; // true once the gate needed no neutral during this press
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
   * @param {() => void} world.ask requests the lease from the server
   * @param {() => number} world.draw a number for a new press, never the same twice
   * @param {() => number} world.count rises over reloads and tabs, so that no frame looks older than one sent before:
   *   the console's steady clock in milliseconds
   * @param {() => void} [world.busy] called when the page came too late to go on driving
   */
  constructor({ send, ask, draw, count, busy = () => undefined }) {
    this.busy = busy;
    this.send = send;
    this.ask = ask;
    this.draw = draw;
    this.count = count;
  }

  get engaged() {
    return this.#engaged;
  }

  /** The reason when an input is held and nothing moves, else "". */
  get why() {
    return this.#why;
  }

  get mustLetGo() {
    return this.#mustLetGo;
  }

  /** @returns {Velocity} requested now; the largest of keys, stick and gamepad on each axis */
  get velocity() {
    /** @param {Velocity} a @param {Velocity} b @returns {Velocity} */
    const stronger = (a, b) => ({
      v: Math.abs(a.v) >= Math.abs(b.v) ? a.v : b.v,
      w: Math.abs(a.w) >= Math.abs(b.w) ? a.w : b.w,
    });
    return stronger(stronger(this.#keys, this.#stick), this.#gamepad);
  }

  /** @returns {{v: number, w: number}} [m/s], [rad/s] setpoint of a frame sent now */
  get setpoint() {
    const scale = (PRESETS[this.preset - 1] ?? 0.6) * (this.slow ? SLOW : 1);
    const { v, w } = this.velocity;
    return { v: v * scale * this.limits.speed, w: w * scale * this.limits.turnRate };
  }

  /** @param {Velocity} velocity @param {number} now [ms] */
  keys(velocity, now) {
    this.#keys = velocity;
    this.#follow(now, true);
  }

  /** @param {Velocity} velocity @param {number} now [ms] */
  stick(velocity, now) {
    this.#stick = velocity;
    this.#follow(now, false);
  }

  /** @param {Velocity} velocity @param {number} now [ms] */
  gamepad(velocity, now) {
    this.#gamepad = velocity;
    this.#follow(now, false);
  }

  /**
   * Take the state of the gate and the permission of this page.
   * @param {{nonce: number, epoch: number, needNeutral: boolean}} gate
   * @param {Permission} permission
   * @param {number} now [ms]
   */
  hear(gate, permission, now) {
    const changedOperator = gate.epoch !== this.#gate.epoch;
    this.#gate = gate;
    this.#permission = permission;
    if (!this.#engaged) {
      if (this.#mustLetGo && permission.may === "no") this.#why = permission.why || this.#why;
      this.#await(now);
      return;
    }
    if (permission.may !== "yes") this.trip(permission.why || t("drive.you_no_longer_drive"));
    else if (changedOperator) this.trip(t("drive.control_changed_hands"));
    else if (!gate.needNeutral) this.#neutralSeen = true;
    else if (this.#neutralSeen) this.trip(t("drive.the_gate_stopped_the_robot"));
    else if (now - this.#engagedAt > NEUTRAL_MS) this.trip(t("drive.the_gate_did_not_take_this"));
  }

  /** Send zero now, and nothing more until every key and the stick are released. @param {string} why a sentence */
  trip(why) {
    this.#asking = -Infinity;
    if (this.#engaged) this.#letGo();
    if (this.#neutral) return;
    this.#mustLetGo = true;
    this.#why = why;
  }

  /** Send zero now and clear the input: the page no longer sees it (blur, hidden, a cancelled pointer). */
  abandon() {
    this.#keys = { v: 0, w: 0 };
    this.#stick = { v: 0, w: 0 };
    this.#gamepad = { v: 0, w: 0 };
    this.#asking = -Infinity;
    this.#mustLetGo = false;
    this.#why = "";
    if (this.#engaged) this.#letGo();
  }

  /** Every PERIOD_MS, from the main thread only. @param {number} now [ms] */
  tick(now) {
    if (this.#engaged && now - this.#sentAt > LATE_MS) {
      this.trip(t("drive.the_page_was_busy_and_lost"));
      this.busy();
    } else if (this.#engaged) this.#sendSetpoint(now);
    else if (this.#zeros > 0) this.#zero();
  }

  get #neutral() {
    const { v, w } = this.velocity;
    return v === 0 && w === 0;
  }

  /**
   * @param {number} now
   * @param {boolean} atOnce send a changed velocity now (keys) or with the next tick (stick, gamepad: they change all the time)
   */
  #follow(now, atOnce) {
    if (this.#neutral) {
      this.#mustLetGo = false;
      this.#why = "";
      this.#asking = -Infinity;
      if (this.#engaged) this.#letGo();
    } else if (this.#engaged) {
      if (atOnce && now - this.#sentAt <= LATE_MS) this.#sendSetpoint(now);
    } else if (!this.#mustLetGo) {
      this.#take(now);
    }
  }

  /** After a press requested control: drive when it is granted, give up when it is not. @param {number} now */
  #await(now) {
    if (this.#asking === -Infinity) return;
    if (now - this.#asking >= ASK_MS) this.trip(t("drive.control_was_not_granted_let_go"));
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
      this.#frame(0, 0); // tells a restarted gate which page drives
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
      this.#sendSetpoint(now);
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
  #sendSetpoint(now) {
    const { v, w } = this.setpoint;
    this.#sentAt = now;
    this.#frame(v, w);
  }

  /** @param {number} v @param {number} w */
  #frame(v, w) {
    this.#seq = Math.max(this.#seq + 1, this.count());
    const { nonce, epoch } = this.#gate;
    this.send({ v, w, press: this.#press, seq: this.#seq, nonce, epoch });
  }
}
