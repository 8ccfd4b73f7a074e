// Written by `python -m console.wire` from console/wire.py; a test keeps the two equal. Do not edit.

/** @typedef {import("./wire-calibration.js").CalibrationAdvice} CalibrationAdvice */
/** @typedef {import("./wire-calibration.js").CalibrationBars} CalibrationBars */
/** @typedef {import("./wire-calibration.js").CalibrationBoard} CalibrationBoard */
/** @typedef {import("./wire-calibration.js").CalibrationCheck} CalibrationCheck */
/** @typedef {import("./wire-calibration.js").CalibrationNews} CalibrationNews */
/** @typedef {import("./wire-calibration.js").CalibrationProgress} CalibrationProgress */
/** @typedef {import("./wire-calibration.js").CalibrationScan} CalibrationScan */
/** @typedef {import("./wire-calibration.js").CalibrationSession} CalibrationSession */
/** @typedef {import("./wire-calibration.js").CalibrationSolving} CalibrationSolving */
/** @typedef {import("./wire-calibration.js").CalibrationUncertainty} CalibrationUncertainty */
/** @typedef {import("./wire-calibration.js").CalibrationVerdict} CalibrationVerdict */
/** @typedef {import("./wire-calibration.js").CalibrationView} CalibrationView */
/** @typedef {import("./wire-floor.js").Candidate} Candidate */
/** @typedef {import("./wire-floor.js").ClosureRow} ClosureRow */
/** @typedef {import("./wire-floor.js").FloorState} FloorState */
/** @typedef {import("./wire-floor.js").LostState} LostState */
/** @typedef {import("./wire-floor.js").MapState} MapState */
/** @typedef {import("./wire-floor.js").Spot} Spot */
/** @typedef {import("./wire-floor.js").SubmapRow} SubmapRow */
/** @typedef {import("./wire-hearing.js").Ears} Ears */
/** @typedef {import("./wire-hearing.js").VoiceHeard} VoiceHeard */
/** @typedef {import("./wire-intent.js").IntentState} IntentState */
/** @typedef {import("./wire-intent.js").Order} Order */
/** @typedef {import("./wire-people.js").BodyPart} BodyPart */
/** @typedef {import("./wire-people.js").PersonState} PersonState */
/** @typedef {import("./wire-people.js").SensedBearing} SensedBearing */
/** @typedef {import("./wire-sight.js").CalibrationDrift} CalibrationDrift */
/** @typedef {import("./wire-sight.js").PictureQuality} PictureQuality */
/** @typedef {import("./wire-up.js").Drive} Drive */
/** @typedef {import("./wire-up.js").Echo} Echo */
/** @typedef {import("./wire-up.js").Halt} Halt */
/** @typedef {import("./wire-up.js").HaltReset} HaltReset */
/** @typedef {import("./wire-up.js").LeaseWish} LeaseWish */
/** @typedef {import("./wire-up.js").Playback} Playback */
/** @typedef {import("./wire-up.js").Say} Say */
/** @typedef {import("./wire-up.js").Stop} Stop */
/** @typedef {import("./wire-up.js").Want} Want */

/**
 * A point of the world frame.
 * @typedef {object} Place
 * @property {number} x_m
 * @property {number} y_m
 */

/**
 * A pose of the world frame and its covariance.
 * @typedef {object} Pose
 * @property {number} x_m
 * @property {number} y_m
 * @property {number} heading_rad
 * @property {number[][]} cov
 */

/**
 * Where the simulated robot really is.
 * @typedef {object} TruePose
 * @property {number} x_m
 * @property {number} y_m
 * @property {number} heading_rad
 */

/**
 * Speeds as the wheels report them.
 * @typedef {object} Velocity
 * @property {number} v_m_s
 * @property {number} w_rad_s
 */

/**
 * A row of the paper's table L.
 * @typedef {object} LandmarkRow
 * @property {number} id
 * @property {number} x_m
 * @property {number} y_m
 * @property {number[][]} cov_m2
 * @property {number} hits
 * @property {number} misses
 * @property {string} kind
 */

/**
 * How the filter fares.
 * @typedef {object} Slam
 * @property {string} mode
 * @property {number} updates
 * @property {number | null} nis
 * @property {[number, number]} nis_band
 * @property {number | null} nees
 * @property {number | null} error_m
 * @property {number | null} error_rad
 * @property {number} matched
 * @property {number} ignored
 * @property {number} tentative
 * @property {number | null} update_ms
 * @property {boolean} looking_around
 */

/**
 * A command and how it goes.
 * @typedef {object} CommandState
 * @property {number} id
 * @property {string} name
 * @property {Object<string, number>} numbers
 * @property {string} heard_as
 * @property {string} source
 * @property {string} who
 * @property {'running' | 'done' | 'refused' | 'cancelled' | 'pre-empted' | 'failed'} state
 * @property {string} remark
 * @property {number | null} progress
 */

/**
 * A vertical edge in the newest picture, in pixels.
 * @typedef {object} EdgeLine
 * @property {number} u0
 * @property {number} v0
 * @property {number} u1
 * @property {number} v1
 * @property {number} bearing_rad
 * @property {boolean} matched
 */

/**
 * What perception drew on the newest picture.
 * @typedef {object} CameraOverlay
 * @property {number} stamp_s
 * @property {number} width
 * @property {number} height
 * @property {EdgeLine[]} edges
 * @property {[number, number, number][]} laser
 * @property {PictureQuality | null} quality
 */

/**
 * The robot and the link to it.
 * @typedef {object} RobotState
 * @property {string} url
 * @property {'SIM' | 'LOG' | 'LIVE'} kind
 * @property {string} name
 * @property {'connecting' | 'live' | 'stale' | 'lost'} link
 * @property {number | null} age_s
 * @property {number} rate_hz
 * @property {boolean} contact
 * @property {boolean} running
 * @property {number | null} progress
 * @property {number} speed
 */

/**
 * What the gate lets through.
 * @typedef {object} GateState
 * @property {string} state
 * @property {string} reason
 * @property {number} v_m_s
 * @property {number} w_rad_s
 * @property {string} source
 * @property {number} nonce
 * @property {number} epoch
 * @property {number | null} limit_v_m_s
 * @property {Place | null} blocked_by
 * @property {boolean} need_neutral
 */

/**
 * Who drives.
 * @typedef {object} LeaseState
 * @property {string | null} holder
 * @property {string | null} holder_id
 * @property {number} epoch
 */

/**
 * A sentence for the operator.
 * @typedef {object} NoticeLine
 * @property {number} id
 * @property {number} stamp_s
 * @property {'info' | 'warning' | 'error'} level
 * @property {string} text
 */

/**
 * Everything that may be shown at one instant; the newest replaces the older.
 * @typedef {object} State
 * @property {'state'} kind
 * @property {number} seq
 * @property {number} stamp_s
 * @property {Pose} pose
 * @property {Pose} dead_reckoning
 * @property {Velocity} velocity
 * @property {LandmarkRow[]} landmarks
 * @property {Slam} slam
 * @property {FloorState} floor
 * @property {MapState} map
 * @property {VoiceHeard | null} direction
 * @property {Ears | null} ears
 * @property {PersonState | null} person
 * @property {Place | null} goal
 * @property {[number, number][]} path
 * @property {CommandState | null} command
 * @property {IntentState | null} intent
 * @property {CameraOverlay | null} camera
 * @property {CalibrationDrift | null} calibration_drift
 * @property {RobotState} robot
 * @property {GateState} gate
 * @property {LeaseState} lease
 * @property {number} viewers
 * @property {NoticeLine[]} notices
 * @property {number} history_revision
 * @property {TruePose | null} truth
 */

/**
 * The person a socket belongs to.
 * @typedef {object} You
 * @property {string} name
 * @property {'viewer' | 'operator' | 'admin'} role
 * @property {string} id
 */

/**
 * What the robot is.
 * @typedef {object} RobotCard
 * @property {string} url
 * @property {'SIM' | 'LOG' | 'LIVE'} kind
 * @property {string} name
 * @property {number} radius_m
 * @property {number} cruise_m_s
 * @property {number} max_speed_m_s
 * @property {number} max_turn_rate_rad_s
 * @property {boolean} drives
 * @property {number | null} duration_s
 */

/**
 * The first message of a socket.
 * @typedef {object} Hello
 * @property {'hello'} kind
 * @property {You} you
 * @property {string} version
 * @property {RobotCard} robot
 * @property {string} tab
 * @property {number} clock_ms
 */

/**
 * What became of a message that carried `ref`; 0 when it carried none.
 * @typedef {object} Answer
 * @property {'answer'} kind
 * @property {number} ref
 * @property {boolean} ok
 * @property {number} status
 * @property {string | null} [detail]
 * @property {string[] | null} [suggestions]
 * @property {number | null} [id]
 */

/**
 * The same number back: measures the link.
 * @typedef {object} EchoBack
 * @property {'echo'} kind
 * @property {number} t
 */

/**
 * The camera arrives as binary: u8 kind = 1, 3 bytes of padding, u32 sequence number, f64 stamp [s], all little
 * endian, then the JPEG.
 */
export const CAMERA_HEADER_BYTES = 16;

/**
 * All that goes up to the console.
 * @typedef {Drive | Stop | Say | LeaseWish | Halt | HaltReset | Playback | Want | Echo} Up
 */

/**
 * All that comes down to the browser.
 * @typedef {Hello | State | CalibrationNews | Answer | EchoBack} Down
 */
