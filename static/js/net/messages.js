// Written by `python -m console.messages.generate_js` from console/messages/state.py; a test keeps the two equal. Do not edit.

/** @typedef {import("./messages-calibration.js").CalibrationAdvice} CalibrationAdvice */
/** @typedef {import("./messages-calibration.js").CalibrationBars} CalibrationBars */
/** @typedef {import("./messages-calibration.js").CalibrationBoard} CalibrationBoard */
/** @typedef {import("./messages-calibration.js").CalibrationCheck} CalibrationCheck */
/** @typedef {import("./messages-calibration.js").CalibrationNews} CalibrationNews */
/** @typedef {import("./messages-calibration.js").CalibrationProgress} CalibrationProgress */
/** @typedef {import("./messages-calibration.js").CalibrationScan} CalibrationScan */
/** @typedef {import("./messages-calibration.js").CalibrationSessionState} CalibrationSessionState */
/** @typedef {import("./messages-calibration.js").CalibrationSolving} CalibrationSolving */
/** @typedef {import("./messages-calibration.js").CalibrationUncertainty} CalibrationUncertainty */
/** @typedef {import("./messages-calibration.js").CalibrationVerdict} CalibrationVerdict */
/** @typedef {import("./messages-calibration.js").CalibrationView} CalibrationView */
/** @typedef {import("./messages-hearing.js").HearingState} HearingState */
/** @typedef {import("./messages-hearing.js").VoiceHeard} VoiceHeard */
/** @typedef {import("./messages-inbound.js").EchoMessage} EchoMessage */
/** @typedef {import("./messages-inbound.js").HaltMessage} HaltMessage */
/** @typedef {import("./messages-inbound.js").HaltResetMessage} HaltResetMessage */
/** @typedef {import("./messages-inbound.js").JogMessage} JogMessage */
/** @typedef {import("./messages-inbound.js").LeaseMessage} LeaseMessage */
/** @typedef {import("./messages-inbound.js").PlaybackMessage} PlaybackMessage */
/** @typedef {import("./messages-inbound.js").SayMessage} SayMessage */
/** @typedef {import("./messages-inbound.js").StopMessage} StopMessage */
/** @typedef {import("./messages-inbound.js").SubscriptionMessage} SubscriptionMessage */
/** @typedef {import("./messages-map.js").CandidateState} CandidateState */
/** @typedef {import("./messages-map.js").ClosureRow} ClosureRow */
/** @typedef {import("./messages-map.js").LocalizationState} LocalizationState */
/** @typedef {import("./messages-map.js").MapState} MapState */
/** @typedef {import("./messages-map.js").PlaceState} PlaceState */
/** @typedef {import("./messages-map.js").SubmapRow} SubmapRow */
/** @typedef {import("./messages-map.js").SubmapsState} SubmapsState */
/** @typedef {import("./messages-pending-command.js").CommandPayload} CommandPayload */
/** @typedef {import("./messages-pending-command.js").LateCommandState} LateCommandState */
/** @typedef {import("./messages-pending-command.js").PendingCommandState} PendingCommandState */
/** @typedef {import("./messages-person.js").BodyPart} BodyPart */
/** @typedef {import("./messages-person.js").PersonState} PersonState */
/** @typedef {import("./messages-person.js").SensedBearing} SensedBearing */
/** @typedef {import("./messages-picture.js").CalibrationDriftState} CalibrationDriftState */
/** @typedef {import("./messages-picture.js").PictureQualityState} PictureQualityState */

/**
 * The result of a message that carried `ref`; 0 when it carried none.
 * @typedef {object} AnswerMessage
 * @property {'answer'} kind
 * @property {number} ref
 * @property {boolean} ok
 * @property {number} status
 * @property {string | null} [detail]
 * @property {string[] | null} [suggestions]
 * @property {number | null} [id]
 * @property {string | null} [code]
 * @property {Object<string, string> | null} [values]
 */

/**
 * The outlines that perception drew on the newest picture.
 * @typedef {object} CameraOverlay
 * @property {number} stamp_s
 * @property {number} width
 * @property {number} height
 * @property {EdgeLine[]} edges
 * @property {[number, number, number][]} laser
 * @property {PictureQualityState | null} quality
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
 * @property {string | null} [code]
 * @property {Object<string, string> | null} [values]
 */

/**
 * The other way of a recording beside the one that is shown, in its world, and the difference in numbers.
 * @typedef {object} ComparisonState
 * @property {TruePose} pose
 * @property {[number, number][]} trail
 * @property {[number, number][]} landmarks
 * @property {number} distance_m
 * @property {number} turn_rad
 * @property {number} worst_m
 * @property {number} recorded_landmarks
 * @property {number} computed_landmarks
 * @property {number} recorded_edges
 * @property {number} computed_edges
 * @property {number | null} direction_rad
 * @property {number} frames
 * @property {boolean} same
 */

/**
 * The same number back: measures the link.
 * @typedef {object} EchoBack
 * @property {'echo'} kind
 * @property {number} t
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
 * The setpoint that the gate lets through.
 * @typedef {object} GateState
 * @property {string} state
 * @property {string} reason
 * @property {number} v_m_s
 * @property {number} w_rad_s
 * @property {string} source
 * @property {number} nonce
 * @property {number} epoch
 * @property {number | null} limit_v_m_s
 * @property {PointState | null} blocked_by
 * @property {boolean} need_neutral
 * @property {string | null} [code]
 * @property {Object<string, string> | null} [values]
 */

/**
 * The first message of a socket.
 * @typedef {object} HelloMessage
 * @property {'hello'} kind
 * @property {You} you
 * @property {string} version
 * @property {RobotCard} robot
 * @property {string} console
 * @property {string} tab
 * @property {number} clock_ms
 * @property {'ours' | 'printed'} chapter
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
 * The time offset between a laser and the odometry, estimated from turns.
 * @typedef {object} LaserTiming
 * @property {string} laser
 * @property {number} offset_s
 * @property {number} sd_s
 * @property {number} applied_s
 */

/**
 * The lease: the operator who drives.
 * @typedef {object} LeaseState
 * @property {string | null} holder
 * @property {string | null} holder_id
 * @property {number} epoch
 * @property {string | null} [asked_by]
 * @property {string | null} [asked_by_id]
 * @property {number | null} [answer_within_s]
 */

/**
 * Moves of the robot by its wheels over those by its scans, as far as it has moved.
 * @typedef {object} MoveAgreementState
 * @property {string} laser
 * @property {number} turns
 * @property {number} ways
 * @property {number | null} turn_scale
 * @property {number | null} turn_scale_sd
 * @property {number | null} way_scale
 * @property {number | null} way_scale_sd
 */

/**
 * A sentence for the operator.
 * @typedef {object} NoticeLine
 * @property {number} id
 * @property {number} stamp_s
 * @property {'info' | 'warning' | 'error'} level
 * @property {string} text
 * @property {string} [cause]
 * @property {string | null} [code]
 * @property {Object<string, string> | null} [values]
 */

/**
 * A recording of Beckon's own: the ways in which it is shown.
 * @typedef {object} PlaybackView
 * @property {string} way
 * @property {boolean} compare
 * @property {string[]} ways
 * @property {number | null} computed_since_s
 * @property {number | null} reached_speed
 * @property {ComparisonState | null} comparison
 */

/**
 * A point of the world frame.
 * @typedef {object} PointState
 * @property {number} x_m
 * @property {number} y_m
 */

/**
 * A pose of the world frame and its covariance.
 * @typedef {object} PoseState
 * @property {number} x_m
 * @property {number} y_m
 * @property {number} heading_rad
 * @property {number[][]} cov
 */

/**
 * The recorder, and what it holds in memory.
 * @typedef {object} RecorderState
 * @property {string | null} name
 * @property {number} seconds
 * @property {number} bytes
 * @property {number} ring_s
 * @property {number} ring_limit_s
 * @property {number} revision
 */

/**
 * The description of the robot.
 * @typedef {object} RobotCard
 * @property {string} url
 * @property {'SIM' | 'LOG' | 'LIVE'} kind
 * @property {string} name
 * @property {number} radius_m
 * @property {[number, number] | null} camera_view_rad
 * @property {number} cruise_m_s
 * @property {number} max_speed_m_s
 * @property {number} max_turn_rate_rad_s
 * @property {boolean} drives
 * @property {boolean} dry_run
 * @property {('drive' | 'simulate' | 'replay' | 'results' | 'navigate')[]} capabilities
 * @property {string} failsafe
 * @property {string} lock
 * @property {number | null} duration_s
 * @property {[number, number][]} gaps_s
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
 * @property {number} pace
 * @property {boolean} contact
 * @property {boolean} running
 * @property {number | null} progress
 * @property {number} speed
 * @property {SensorLine[]} sensors
 * @property {LaserTiming[]} timings
 * @property {MoveAgreementState | null} agreement
 * @property {number | null} battery
 */

/**
 * A sensor of the robot, and whether it delivers.
 * @typedef {object} SensorLine
 * @property {'wheels' | 'laser' | 'camera' | 'microphones'} kind
 * @property {string} name
 * @property {'live' | 'stale' | 'lost'} state
 * @property {number} age_s
 * @property {number} rate_hz
 */

/**
 * How the filter fares.
 * @typedef {object} SlamState
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
 * Everything that may be shown at one instant; the newest replaces the older.
 * @typedef {object} State
 * @property {'state'} kind
 * @property {number} seq
 * @property {number} stamp_s
 * @property {PoseState} pose
 * @property {PoseState} dead_reckoning
 * @property {Velocity} velocity
 * @property {LandmarkRow[]} landmarks
 * @property {SlamState} slam
 * @property {SubmapsState} floor
 * @property {MapState} map
 * @property {VoiceHeard | null} direction
 * @property {HearingState | null} ears
 * @property {PersonState | null} person
 * @property {PointState | null} goal
 * @property {[number, number][]} path
 * @property {CommandState | null} command
 * @property {PendingCommandState | null} pending_command
 * @property {LateCommandState | null} late_command
 * @property {CameraOverlay | null} camera
 * @property {CalibrationDriftState | null} calibration_drift
 * @property {RobotState} robot
 * @property {GateState} gate
 * @property {LeaseState} lease
 * @property {RecorderState | null} recording
 * @property {PlaybackView | null} playback
 * @property {number} viewers
 * @property {NoticeLine[]} notices
 * @property {number} history_revision
 * @property {TruePose | null} truth
 * @property {'ours' | 'printed'} [chapter]
 */

/**
 * The true pose of the simulated robot.
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
 * The person a socket belongs to.
 * @typedef {object} You
 * @property {string} name
 * @property {'viewer' | 'operator' | 'admin'} role
 * @property {string} id
 */

/**
 * The camera arrives as binary: u8 kind = 1, 3 bytes of padding, u32 sequence number, f64 stamp [s], all little
 * endian, then the JPEG.
 */
export const CAMERA_HEADER_BYTES = 16;

/**
 * All that goes up to the console.
 * @typedef {JogMessage | StopMessage | SayMessage | LeaseMessage | HaltMessage | HaltResetMessage | PlaybackMessage | SubscriptionMessage | EchoMessage} Up
 */

/**
 * All that comes down to the browser.
 * @typedef {HelloMessage | State | CalibrationNews | AnswerMessage | EchoBack} Down
 */
