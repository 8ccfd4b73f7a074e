// Written by `python -m console.messages.generate_js` from console/messages/pending_command.py; a test keeps the two equal. Do not edit.

/**
 * A command as it was understood.
 * @typedef {object} CommandPayload
 * @property {number} id
 * @property {string} name
 * @property {Object<string, number>} numbers
 * @property {string} heard_as
 * @property {string} source
 * @property {string} who
 */

/**
 * A spoken command that was refused because it came too late; it begins as a pending command does.
 * @typedef {object} LateCommandState
 * @property {number} id
 * @property {string} heard_as
 */

/**
 * A spoken command that was understood and has not begun, and its preview as the robot stands now.
 * @typedef {object} PendingCommandState
 * @property {number} id
 * @property {string} name
 * @property {Object<string, number>} numbers
 * @property {string} heard_as
 * @property {string} source
 * @property {string} who
 * @property {number} begins_in_s
 * @property {number} delay_s
 * @property {'none' | 'place' | 'person'} target
 * @property {boolean} uncertain
 * @property {string[]} alternatives
 * @property {[number, number][]} way
 * @property {[number, number] | null} goal
 * @property {number | null} heading_rad
 * @property {number | null} bearing_rad
 * @property {number | null} bearing_sd_rad
 */

export {};
