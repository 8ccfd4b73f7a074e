// Written by `python -m console.messages.generate_js` from console/messages/picture.py; a test keeps the two equal. Do not edit.

/**
 * How the camera's mount seems to differ from the calibration in use.
 * @typedef {object} CalibrationDriftState
 * @property {number} turn_rad
 * @property {number} turn_sd_rad
 * @property {number} apparent_rad
 * @property {number} apparent_sd_rad
 * @property {number} shift_m
 * @property {number} shift_sd_m
 * @property {number} pairs
 * @property {number} corners
 * @property {boolean} alarm
 * @property {string} words
 */

/**
 * How good the newest picture is, and how it was corrected; grey levels are 0..255.
 * @typedef {object} PictureQualityState
 * @property {'good' | 'mended' | 'poor' | 'unusable'} state
 * @property {string} label
 * @property {string} words
 * @property {number} mean
 * @property {number} low
 * @property {number} high
 * @property {number} dark_share
 * @property {number} bright_share
 * @property {number} noise_sd
 * @property {number} snr_db
 * @property {number | null} blur_px
 * @property {number | null} blur_down_px
 * @property {number} margin
 * @property {number} gain
 * @property {number} gamma
 * @property {number} contrast
 * @property {number} smoothing
 */

export {};
