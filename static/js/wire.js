// Written by `python -m console.wire` from console/wire.py; a test keeps the two equal. Do not edit.

/**
 * The camera arrives as binary: u8 kind = 1, 3 bytes of padding, u32 sequence number, f64 stamp [s], all little
 * endian, then the JPEG.
 */
export const CAMERA_HEADER_BYTES = 16;

/**
 * The next view to take.
 * @typedef {object} CalibrationAdvice
 * @property {string} words
 * @property {[number, number][]} outline
 * @property {[number, number][]} corners
 */

/**
 * How far the views span place, size and skew, 0..1.
 * @typedef {object} CalibrationBars
 * @property {number} x
 * @property {number} y
 * @property {number} size
 * @property {number} skew
 */

/**
 * The chessboard, counted in inner corners.
 * @typedef {object} CalibrationBoard
 * @property {number} columns
 * @property {number} rows
 * @property {number} square_m
 * @property {[number, number] | null} [panel_m]
 */

/**
 * How the solution predicted a pose that had no part in it.
 * @typedef {object} CalibrationCheck
 * @property {string} name
 * @property {number} off_px
 * @property {number} residual_rms_m
 * @property {number} beams
 * @property {string} words
 */

/**
 * A session has changed; sent whole, the newest only, at most ten times a second (a counted view at once).
 * @typedef {object} CalibrationNews
 * @property {'calibration'} kind
 * @property {CalibrationSession} session
 */

/**
 * How far the wizard is; the lower keys belong to one kind of session only.
 * @typedef {object} CalibrationProgress
 * @property {number} views
 * @property {boolean} ready
 * @property {string} words
 * @property {number | null} [p95_px]
 * @property {number | null} [target_px]
 * @property {CalibrationBars | null} [bars]
 * @property {number[][] | null} [cells]
 * @property {Object<string, number> | null} [gains]
 * @property {string[] | null} [weak]
 * @property {string | null} [landing]
 * @property {Object<string, string> | null} [witnessed]
 * @property {number | null} [known_from]
 */

/**
 * The laser's newest scan in its own frame [m]; `board` are indices of `points`.
 * @typedef {object} CalibrationScan
 * @property {[number, number][]} points
 * @property {[number, number][]} background
 * @property {number[]} board
 */

/**
 * Everything about one calibration.
 * @typedef {object} CalibrationSession
 * @property {string} id
 * @property {'camera' | 'laser'} kind
 * @property {'robot' | 'upload' | 'webcam'} source
 * @property {CalibrationBoard} board
 * @property {number} created_s
 * @property {number | null} [height_m]
 * @property {[number, number] | null} [size]
 * @property {boolean} [live]
 * @property {boolean} [showing]
 * @property {CalibrationVerdict | null} [verdict]
 * @property {CalibrationAdvice | null} [advice]
 * @property {CalibrationProgress} [progress]
 * @property {CalibrationUncertainty | null} [uncertainty]
 * @property {CalibrationView[]} [views]
 * @property {CalibrationSolving | null} [solving]
 * @property {Object<string, any> | null} [solution]
 * @property {CalibrationCheck | null} [check]
 * @property {number | null} [accepted_s]
 * @property {Object<string, [number, number]> | null} [in_use_compare]
 * @property {CalibrationScan | null} [scan]
 */

/**
 * A solution is being made.
 * @typedef {object} CalibrationSolving
 * @property {number} since_s
 * @property {string} words
 */

/**
 * Standard deviation of the projection over the picture, row by row.
 * @typedef {object} CalibrationUncertainty
 * @property {number} columns
 * @property {number} rows
 * @property {((number | null)[])[]} sd_px
 */

/**
 * What became of one picture or scan; `number` counts them.
 * @typedef {object} CalibrationVerdict
 * @property {'nothing' | 'refused' | 'moving' | 'same' | 'counted' | 'background' | 'gathering' | 'trouble'} kind
 * @property {string} words
 * @property {string} [name]
 * @property {number} [number]
 * @property {[number, number][] | null} [corners]
 * @property {[number, number, number, boolean][] | null} [laser]
 * @property {number[] | null} [beams]
 * @property {number | null} [stamp_s]
 */

/**
 * A view or a pose in the session.
 * @typedef {object} CalibrationView
 * @property {string} name
 * @property {boolean} dropped
 * @property {number | null} [rms_px]
 * @property {number | null} [rms_m]
 * @property {boolean | null} [used]
 * @property {string} [reason]
 */

/**
 * A pose of the world frame where the robot may be.
 * @typedef {object} Candidate
 * @property {number} x_m
 * @property {number} y_m
 * @property {number} heading_rad
 */

/**
 * A place that was recognised.
 * @typedef {object} ClosureRow
 * @property {number} id
 * @property {number} stamp_s
 * @property {number} submap_from
 * @property {number} submap_to
 * @property {Spot} position_from
 * @property {Spot} position_to
 * @property {number} score
 * @property {'accepted' | 'undone' | 'doubtful'} state
 * @property {string} words
 */

/**
 * How the scan layer fares.
 * @typedef {object} FloorState
 * @property {SubmapRow[]} submaps
 * @property {ClosureRow[]} closures
 * @property {number} closures_count
 * @property {LostState | null} lost
 * @property {number | null} match_score
 * @property {boolean} slipping
 * @property {number} graph_revision
 */

/**
 * The robot does not know where it is.
 * @typedef {object} LostState
 * @property {'searching' | 'confirming' | 'asking'} phase
 * @property {string} words
 * @property {number} since_s
 * @property {Candidate[]} candidates
 */

/**
 * Which saved map the robot goes on in.
 * @typedef {object} MapState
 * @property {string | null} name
 * @property {number} revision
 */

/**
 * A point of the world frame.
 * @typedef {object} Spot
 * @property {number} x_m
 * @property {number} y_m
 */

/**
 * A room as the map has it.
 * @typedef {object} SubmapRow
 * @property {number} id
 * @property {number} x_m
 * @property {number} y_m
 * @property {number} heading_rad
 * @property {[number, number, number, number]} extent_m
 * @property {boolean} active
 */

/**
 * What the robot's ears make of the sound.
 * @typedef {object} Ears
 * @property {boolean} listening
 * @property {boolean} muted
 * @property {boolean} obeyed
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

/**
 * How the camera's mount seems to differ from the calibration in use.
 * @typedef {object} CalibrationDrift
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
 * How good the newest picture is, and what was done about it; grey levels are 0..255.
 * @typedef {object} PictureQuality
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
 * Latch a stop.
 * @typedef {object} Halt
 * @property {'halt'} kind
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
 * Words for the robot.
 * @typedef {object} Say
 * @property {'command'} kind
 * @property {string} text
 * @property {'typed' | 'chip' | 'click'} source
 * @property {number} ref
 */

/**
 * Everything cancelled, zero speed. `press` (0: none): its copy over HTTP does nothing.
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
 * All that goes up to the console.
 * @typedef {Drive | Stop | Say | LeaseWish | Halt | HaltReset | Playback | Want | Echo} Up
 */

/**
 * All that comes down to the browser.
 * @typedef {Hello | State | CalibrationNews | Answer | EchoBack} Down
 */
