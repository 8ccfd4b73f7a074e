// Types of the calibration messages; no code.

/** @typedef {import("../net/messages.js").CalibrationSessionState} SessionState the console also sends default values */
/** @typedef {import("../net/messages.js").CalibrationVerdict} Verdict what became of one picture or scan */
/** @typedef {import("../net/messages.js").CalibrationAdvice} Advice the next view to take */
/** @typedef {import("../net/messages.js").CalibrationProgress} Progress how far it is */
/** @typedef {import("../net/messages.js").CalibrationUncertainty} Uncertainty of the projection over the picture */
/** @typedef {import("../net/messages.js").CalibrationView} ViewRow one view or pose that was taken */
/** @typedef {import("../net/messages.js").CalibrationScan} ScanPicture points [m] in the laser's frame */
/** @typedef {import("../net/messages.js").CalibrationBoard} Board counted in inner corners */
/** @typedef {{verdict: Verdict | null, progress: Progress, views: ViewRow[]}} Whole */
/** @typedef {Omit<SessionState, keyof Whole> & Whole} Calibration a session of one of the wizards */
/** @typedef {Calibration["kind"]} Kind */
/** @typedef {Calibration["source"]} Source */
/** @typedef {[number, number]} Pixel u, v; the centre of the top left one is 0, 0 */

export {};
