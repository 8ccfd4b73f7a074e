// Who was near the robot in the last minute: voices by their direction, people by where they were seen.

/** @import { State } from "../net/messages.js" */
/**
 * @typedef {object} Sighting
 * @property {string} id
 * @property {boolean} seen by camera or laser; else heard
 * @property {number} azimuth [rad] robot frame, as it stands now
 * @property {number} age [s]
 */
/** @typedef {{seen: boolean, at: number, bearing: number, place: [number, number] | null}} Remembered [s], [rad] world, [m] */

const REMEMBERED_S = 60;
const MOST = 6;
const SAME = 0.3; // [rad] within which a later voice is the same one

export class Near {
  /** @type {Map<string, Remembered>} */
  #known = new Map();
  #count = 0;
  /** @type {{x_m: number, y_m: number, heading_rad: number}} */
  #pose = { x_m: 0, y_m: 0, heading_rad: 0 };

  /** @param {State} state @returns {Sighting[]} newest first */
  saw({ stamp_s: now, pose, ears, person }) {
    this.#pose = pose;
    for (const voice of ears?.voices ?? []) {
      const bearing = voice.azimuth_world_rad;
      this.#note({ seen: false, at: now - voice.age_s, bearing, place: null });
    }
    if (person) {
      const place = /** @type {[number, number]} */ ([person.x_m, person.y_m]);
      this.#note({ seen: true, at: now - person.age_s, bearing: 0, place });
    }
    for (const [id, { at }] of this.#known) if (now - at > REMEMBERED_S || at > now) this.#known.delete(id); // another clock: the robot was started again
    return [...this.#known]
      .map(([id, one]) => ({
        id,
        seen: one.seen,
        azimuth: angle(this.#bearing(one) - pose.heading_rad),
        age: now - one.at,
      }))
      .sort((one, other) => one.age - other.age)
      .slice(0, MOST);
  }

  /** @param {string} id @returns {number | null} [rad] world, from where the robot is now; null: forgotten */
  towards(id) {
    const one = this.#known.get(id);
    return one ? angle(this.#bearing(one)) : null;
  }

  /** @param {Remembered} one */
  #note(one) {
    const same = [...this.#known].find(
      ([, known]) => known.seen === one.seen && Math.abs(angle(this.#bearing(known) - this.#bearing(one))) < SAME,
    );
    if (!same) this.#count += 1;
    if (!same || same[1].at <= one.at) this.#known.set(same?.[0] ?? `near ${this.#count}`, one);
  }

  /** @param {Remembered} one */
  #bearing({ bearing, place }) {
    return place ? Math.atan2(place[1] - this.#pose.y_m, place[0] - this.#pose.x_m) : bearing;
  }
}

/** @param {number} radians */
const angle = (radians) => Math.atan2(Math.sin(radians), Math.cos(radians));
