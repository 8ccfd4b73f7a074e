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

const WALKS_M = [2.5, 2, 1.5, 1];
const WALKS_M_S = 0.2; // at which the robot follows
const TURNS = [0, 0.6, -0.6, 1.2, -1.2, 1.8, -1.8]; // [rad] from straight away from the robot

/**
 * Let someone walk away from the robot, as far as there is floor.
 * @param {PersonInRoom} one
 * @param {{x_m: number, y_m: number}} robot
 */
export async function walk({ id, x_m, y_m }, robot) {
  const away = Math.atan2(y_m - robot.y_m, x_m - robot.x_m);
  /** @type {unknown} */
  let refusal;
  for (const far of WALKS_M)
    for (const turn of TURNS) {
      const heading_rad = away + turn;
      const path_m = [[x_m + far * Math.cos(heading_rad), y_m + far * Math.sin(heading_rad)]];
      try {
        return await post("api/sim/place", { what: "person", id, x_m, y_m, heading_rad, path_m, speed_m_s: WALKS_M_S });
      } catch (refused) {
        refusal = refused; // a wall or a thing is in the way
      }
    }
  throw refusal;
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
