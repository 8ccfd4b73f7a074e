// HTTP client for the simulated room: who is in it, and what they say.

import { call, obeyVoices, post } from "./api.js";

/** @import { PersonInRoom } from "./rest.js" */

/** @returns {Promise<PersonInRoom[]>} */
export const people = async () => (await call("api/sim/people")).people.sort(byName);

/** @param {PersonInRoom} one @param {PersonInRoom} other */
const byName = (one, other) => one.id.localeCompare(other.id);

/**
 * Let someone in the room speak to the robot, which then obeys the voices of the room.
 * @param {string} id
 * @param {string} text
 */
export async function speak(id, text) {
  await obeyVoices(true);
  await post("api/sim/say", { id, text });
}

const [NEAR, FAR, STEP] = [1.2, 2.4, 0.3]; // [m] before the robot, where a person may stand
const ASIDE = [0, 0.5, -0.5, 1, -1]; // [rad]

/**
 * Put a person into the room, before the robot where there is space.
 * @param {{x_m: number, y_m: number, heading_rad: number}} pose of the robot
 */
export async function add({ x_m: x, y_m: y, heading_rad: heading }) {
  /** @type {unknown} */
  let refusal;
  for (const aside of ASIDE)
    for (let away = FAR; away >= NEAR; away -= STEP) {
      const at = { x_m: x + away * Math.cos(heading + aside), y_m: y + away * Math.sin(heading + aside) };
      try {
        return await post("api/sim/place", { what: "person", id: "Ann", ...at, heading_rad: heading + Math.PI });
      } catch (refused) {
        refusal = refused; // a wall or a thing is there
      }
    }
  throw refusal;
}
