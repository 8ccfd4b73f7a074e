// What the robot has of a person by each sense, from the state message.

import { t } from "./texts.js";

/** @import { Kind } from "../drive/suggest.js" */
/** @import { State } from "../net/messages.js" */
/**
 * @typedef {object} Sensed
 * @property {{azimuth: number, sd: number} | null} heard [rad] robot frame
 * @property {{value: number | null, name: string} | null} seen K of eq. 34, where the picture has one, and who it is
 * @property {number | null} laser [m] distance of the legs
 * @property {number | null} left [m] to go
 * @property {boolean} found true from the moment that someone was found
 * @property {boolean} looks true while the robot looks for who spoke
 */

const STANDOFF = 0.5; // [m] from the person at which COME HERE ends
export const VOICE_S = 60; // [s] after which where a voice came from says little
const PICTURE_S = 1.5;
const LOOKS = ["come.look_who_spoke", "come.voice_elsewhere"]; // codes of remarks while the robot looks

/** Parts of a person, in words. @type {Record<string, string>} */
export const PARTS = { head: t("sensed.head"), torso: t("sensed.torso"), feet: t("sensed.feet") };

/** The voice that was heard last, also when the state no longer has it. */
export class LastVoice {
  /** @type {{world: number, sd: number, at: number} | null} [rad], [rad], [s] of the robot's clock */
  #heard = null;

  /** @param {number} now [s] of the robot's clock @returns {number | null} [s] since then; null: nobody was heard */
  age(now) {
    return this.#heard && now >= this.#heard.at ? now - this.#heard.at : null;
  }

  /**
   * @param {State} state
   * @returns {{azimuth: number, sd: number, age: number} | null} [rad] robot frame as it stands now, [rad], [s]
   */
  saw({ direction, pose, stamp_s: now }) {
    if (direction)
      this.#heard = { world: direction.azimuth_world_rad, sd: direction.sd_heard_rad, at: now - direction.age_s };
    if (!this.#heard || now - this.#heard.at > VOICE_S || now < this.#heard.at) return null;
    return { azimuth: seenFrom(this.#heard.world, pose), sd: this.#heard.sd, age: now - this.#heard.at };
  }
}

/** Where a direction of the world lies for the robot. @param {number} world [rad] @param {State["pose"]} pose @returns {number} [rad] */
function seenFrom(world, { heading_rad: heading }) {
  return Math.atan2(Math.sin(world - heading), Math.cos(world - heading));
}

/** The voice that a command is about: what speaks once the person was found is someone else, or an echo. */
export class CommandVoice {
  #id = 0;
  /** @type {{world: number, sd: number} | null} [rad] */
  #kept = null;

  /**
   * @param {State} state
   * @param {{azimuth: number, sd: number} | null} voice that was heard last
   * @returns {{azimuth: number, sd: number} | null} [rad] robot frame as it stands now
   */
  of({ command, person, pose }, voice) {
    const id = command?.id ?? 0;
    if (id !== this.#id || person === null)
      this.#kept = voice && { world: voice.azimuth + pose.heading_rad, sd: voice.sd };
    this.#id = id;
    return this.#kept && { azimuth: seenFrom(this.#kept.world, pose), sd: this.#kept.sd };
  }
}

/**
 * @param {State} state
 * @param {{azimuth: number, sd: number} | null} heard
 * @param {readonly Kind[]} kinds the vocabulary
 * @returns {Sensed | null} null while nothing is done for a person
 */
export function chainOf({ command, person, pose }, heard, kinds) {
  const kind = kinds.find(({ name }) => name === command?.name);
  if (command?.state !== "running" || kind?.target !== "person") return null;
  const seen = person !== null && person.camera !== null && (person.picture_age_s ?? Infinity) < PICTURE_S;
  /** @param {number} x @param {number} y */
  const away = (x, y) => Math.hypot(x - pose.x_m, y - pose.y_m);
  return {
    heard,
    seen: seen ? { value: person.value, name: person.name } : null,
    laser: person?.laser ? away(...person.laser) : null,
    left: person ? Math.max(0, away(person.x_m, person.y_m) - STANDOFF) : null,
    found: person !== null,
    looks: person === null && LOOKS.includes(command.code ?? ""),
  };
}
