// HTTP client for the simulated room: who is in it, and what they say.

import { call, obeyVoices, post } from "./api.js";

/**
 * @typedef {object} PersonInRoom
 * @property {string} id
 * @property {number} x_m world
 * @property {number} y_m
 * @property {string} clothes
 */

/** @returns {Promise<PersonInRoom[]>} */
export const people = async () => (await call("api/sim/people")).people;

/**
 * Let somebody in the room speak to the robot, which then obeys the voices of the room.
 * @param {string} id
 * @param {string} text
 */
export async function speak(id, text) {
  await obeyVoices(true);
  await post("api/sim/say", { id, text });
}
