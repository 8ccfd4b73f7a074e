// Written by `python -m console.messages.generate_js` from console/messages/inbound.py; a test keeps the two equal. Do not edit.

/**
 * Comes back as it is.
 * @typedef {object} EchoMessage
 * @property {'echo'} kind
 * @property {number} t
 */

/**
 * Latch a stop. `press` as of `StopMessage`.
 * @typedef {object} HaltMessage
 * @property {'halt'} kind
 * @property {number} [press]
 */

/**
 * Undo the latch; never moves.
 * @typedef {object} HaltResetMessage
 * @property {'halt_reset'} kind
 * @property {number} ref
 */

/**
 * Hold to drive: sent at 20 Hz while a key or the pad is held. `press` is drawn again with every press.
 * @typedef {object} JogMessage
 * @property {'drive'} kind
 * @property {number} v
 * @property {number} w
 * @property {number} press
 * @property {number} seq
 * @property {number} nonce
 * @property {number} epoch
 */

/**
 * Take control, take it over, give it back; ask who has it; the answer to who asks: give or keep.
 * @typedef {object} LeaseMessage
 * @property {'lease'} kind
 * @property {'acquire' | 'take' | 'release' | 'ask' | 'give' | 'keep'} do
 * @property {number} ref
 */

/**
 * Steer a recording: `t_s` [s] from its start is the place to seek, `speed` is in times real time.

    `way` shows what was recorded, or what is computed now; with `compare` one over the other.
 * @typedef {object} PlaybackMessage
 * @property {'playback'} kind
 * @property {'play' | 'pause' | 'seek' | 'speed' | 'way'} action
 * @property {number} ref
 * @property {number | null} [t_s]
 * @property {number | null} [speed]
 * @property {'recorded' | 'computed' | null} [way]
 * @property {boolean} [compare]
 */

/**
 * Words for the robot. `seen`: `seq` of the newest state that the page has (0: none), which dates them.
 * @typedef {object} SayMessage
 * @property {'command'} kind
 * @property {string} text
 * @property {'typed' | 'chip' | 'click'} source
 * @property {number} ref
 * @property {number} [seen]
 */

/**
 * Everything cancelled, zero speed. `press` (0: none): its copy over HTTP is recorded once.
 * @typedef {object} StopMessage
 * @property {'stop'} kind
 * @property {number} [press]
 */

/**
 * Subscriptions of this socket: the camera, and a calibration session (null: none); what is left out stays.
 * @typedef {object} SubscriptionMessage
 * @property {'want'} kind
 * @property {boolean} [camera]
 * @property {string | null} [calibration]
 */

export {};
