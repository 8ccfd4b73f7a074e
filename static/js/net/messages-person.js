// Written by `python -m console.messages.generate_js` from console/messages/person.py; a test keeps the two equal. Do not edit.

/**
 * One part of a person's rectangle in the picture.
 * @typedef {object} BodyPart
 * @property {'head' | 'torso' | 'feet'} name
 * @property {number | null} likelihood
 * @property {[number, number, number, number]} box_px
 */

/**
 * The person whom the running command follows: by every sense alone, and by all together.
 * @typedef {object} PersonState
 * @property {'seen' | 'hidden'} state
 * @property {number} age_s
 * @property {number} x_m
 * @property {number} y_m
 * @property {number[][]} cov_m2
 * @property {('laser' | 'camera' | 'sound')[]} used
 * @property {[number, number] | null} laser
 * @property {SensedBearing | null} camera
 * @property {SensedBearing | null} sound
 * @property {number | null} value
 * @property {BodyPart[]} parts
 * @property {([number, number] | null)[]} landmarks_px
 * @property {number | null} picture_age_s
 * @property {[number, number] | null} centre_px
 * @property {string} name
 */

/**
 * A bearing of a person, with the point from which they are seen or heard.
 * @typedef {object} SensedBearing
 * @property {number} x_m
 * @property {number} y_m
 * @property {number} azimuth_world_rad
 * @property {number} sd_rad
 */

export {};
