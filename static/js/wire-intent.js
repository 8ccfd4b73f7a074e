// Written by `python -m console.wire` from console/wire_intent.py; a test keeps the two equal. Do not edit.

/**
 * A spoken order that was understood and has not begun, and what it would do as the robot stands now.
 * @typedef {object} IntentState
 * @property {number} id
 * @property {string} name
 * @property {Object<string, number>} numbers
 * @property {string} heard_as
 * @property {string} source
 * @property {string} who
 * @property {number} begins_in_s
 * @property {number} moment_s
 * @property {boolean} unsure
 * @property {[number, number][]} way
 * @property {[number, number] | null} goal
 * @property {number | null} heading_rad
 * @property {number | null} bearing_rad
 * @property {number | null} bearing_sd_rad
 */

/**
 * An order as it was understood.
 * @typedef {object} Order
 * @property {number} id
 * @property {string} name
 * @property {Object<string, number>} numbers
 * @property {string} heard_as
 * @property {string} source
 * @property {string} who
 */

export {};
