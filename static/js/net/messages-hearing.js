// Written by `python -m console.messages.generate_js` from console/messages/hearing.py; a test keeps the two equal. Do not edit.

/**
 * The state of the robot's hearing.
 * @typedef {object} HearingState
 * @property {boolean} listening
 * @property {boolean} muted
 * @property {boolean} voice_control
 * @property {boolean} starting
 * @property {string[]} suggested_commands
 * @property {boolean} speaking
 * @property {number | null} level_dbfs
 * @property {VoiceHeard[]} voices
 */

/**
 * A voice and its direction, as heard from the robot.
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
