// Written by `python -m console.wire` from console/wire_people.py; a test keeps the two equal. Do not edit.

/**
 * One part of somebody's rectangle in the picture.
 * @typedef {object} BodyPart
 * @property {'head' | 'torso' | 'feet'} name
 * @property {number | null} likelihood
 * @property {[number, number, number, number]} box_px
 */

/**
 * Who the running command looks at: by every sense alone, and by all together.
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
 * @property {number | null} picture_age_s
 * @property {[number, number] | null} centre_px
 */

/**
 * From where somebody is seen or heard in which direction.
 * @typedef {object} SensedBearing
 * @property {number} x_m
 * @property {number} y_m
 * @property {number} azimuth_world_rad
 * @property {number} sd_rad
 */

export {};
