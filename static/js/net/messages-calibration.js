// Written by `python -m console.messages.generate_js` from console/messages/calibration.py; a test keeps the two equal. Do not edit.

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
 * @property {CalibrationSessionState} session
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
 * @property {Object<string, number> | null} [precision]
 * @property {string[] | null} [weak]
 * @property {string | null} [laser_offset]
 * @property {Object<string, string> | null} [from_ruler]
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
 * @typedef {object} CalibrationSessionState
 * @property {string} id
 * @property {'camera' | 'laser'} kind
 * @property {'robot' | 'upload' | 'webcam'} source
 * @property {CalibrationBoard} board
 * @property {number} created_s
 * @property {number | null} [height_m]
 * @property {[number, number] | null} [size]
 * @property {boolean} [live]
 * @property {boolean} [demo]
 * @property {CalibrationVerdict | null} [verdict]
 * @property {CalibrationAdvice | null} [advice]
 * @property {CalibrationProgress} [progress]
 * @property {CalibrationUncertainty | null} [uncertainty]
 * @property {CalibrationView[]} [views]
 * @property {CalibrationSolving | null} [solving]
 * @property {Object<string, any> | null} [solution]
 * @property {CalibrationCheck | null} [check]
 * @property {number | null} [accepted_s]
 * @property {Object<string, [number, number]> | null} [active_compare]
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
 * The verdict on one picture or scan; `number` counts them.
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

export {};
