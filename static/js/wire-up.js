// Written by `python -m console.wire` from console/wire_up.py; a test keeps the two equal. Do not edit.

/**
 * Hold to drive: sent at 20 Hz while a key or the pad is held. `press` is drawn anew with every press.
 * @typedef {object} Drive
 * @property {'drive'} kind
 * @property {number} v
 * @property {number} w
 * @property {number} press
 * @property {number} seq
 * @property {number} nonce
 * @property {number} epoch
 */

/**
 * Comes back as it is.
 * @typedef {object} Echo
 * @property {'echo'} kind
 * @property {number} t
 */

/**
 * Latch a stop. `press` as of `Stop`.
 * @typedef {object} Halt
 * @property {'halt'} kind
 * @property {number} [press]
 */

/**
 * Undo the latch; never moves.
 * @typedef {object} HaltReset
 * @property {'halt_reset'} kind
 * @property {number} ref
 */

/**
 * Take the wheel, take it over, give it back.
 * @typedef {object} LeaseWish
 * @property {'lease'} kind
 * @property {'acquire' | 'take' | 'release'} do
 * @property {number} ref
 */

/**
 * Steer a recording: `value` is the speed (times real time) or the place to seek (0..1).
 * @typedef {object} Playback
 * @property {'playback'} kind
 * @property {'play' | 'pause' | 'speed' | 'seek'} do
 * @property {number} ref
 * @property {number | null} [value]
 */

/**
 * Words for the robot. `seen`: `seq` of the newest state that the page has (0: none), which dates them.
 * @typedef {object} Say
 * @property {'command'} kind
 * @property {string} text
 * @property {'typed' | 'chip' | 'click'} source
 * @property {number} ref
 * @property {number} [seen]
 */

/**
 * Everything cancelled, zero speed. `press` (0: none): its copy over HTTP is recorded once.
 * @typedef {object} Stop
 * @property {'stop'} kind
 * @property {number} [press]
 */

/**
 * Whether this socket wants the camera, and which calibration session (null: none); what is left out stays.
 * @typedef {object} Want
 * @property {'want'} kind
 * @property {boolean} [camera]
 * @property {string | null} [calibration]
 */

export {};
