// Written by `python -m console.wire` from console/wire_hearing.py; a test keeps the two equal. Do not edit.

/**
 * What the robot's ears make of the sound.
 * @typedef {object} Ears
 * @property {boolean} listening
 * @property {boolean} muted
 * @property {boolean} obeyed
 * @property {boolean} waking
 * @property {string} meant
 * @property {boolean} speaking
 * @property {number | null} level_dbfs
 * @property {VoiceHeard[]} voices
 */

/**
 * Where somebody speaks, as heard from the robot.
 * @typedef {object} VoiceHeard
 * @property {number} id
 * @property {number} azimuth_rad
 * @property {number} azimuth_world_rad
 * @property {number} sd_rad
 * @property {number} sd_heard_rad
 * @property {number | null} elevation_rad
 * @property {string} ambiguity
 * @property {number} strength
 * @property {number} age_s
 * @property {number} x_m
 * @property {number} y_m
 * @property {[number, number, number] | null} columns_px
 */

export {};
