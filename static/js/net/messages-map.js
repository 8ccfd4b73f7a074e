// Written by `python -m console.messages.generate_js` from console/messages/map.py; a test keeps the two equal. Do not edit.

/**
 * A pose of the world frame where the robot may be.
 * @typedef {object} CandidateState
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
 * @property {PlaceState} position_from
 * @property {PlaceState} position_to
 * @property {number} score
 * @property {'accepted' | 'undone' | 'doubtful'} state
 * @property {string} words
 */

/**
 * The robot does not know where it is.
 * @typedef {object} LocalizationState
 * @property {'searching' | 'confirming' | 'asking'} phase
 * @property {string} words
 * @property {number} since_s
 * @property {CandidateState[]} candidates
 */

/**
 * Which saved map the robot goes on in.
 * @typedef {object} MapState
 * @property {string | null} name
 * @property {number} revision
 * @property {boolean} unsaved
 * @property {number} marks
 */

/**
 * A point of the world frame.
 * @typedef {object} PlaceState
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
 * How the scan layer fares.
 * @typedef {object} SubmapsState
 * @property {SubmapRow[]} submaps
 * @property {ClosureRow[]} closures
 * @property {number} closures_count
 * @property {LocalizationState | null} lost
 * @property {number | null} match_score
 * @property {boolean} slipping
 * @property {number} graph_revision
 */

export {};
