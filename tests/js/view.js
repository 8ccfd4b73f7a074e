// A view as the server would make it, for tests: an operator at a simulated robot that stands in a known room.

/** @typedef {import("../../static/js/net/session.js").View} View */
/** @typedef {import("../../static/js/net/messages.js").State} State */
/** @typedef {import("../../static/js/net/messages.js").HelloMessage} Hello */

/** @type {Hello} */
export const HELLO = {
  kind: "hello",
  you: { name: "Ada", role: "operator", id: "ada-1" },
  version: "0.1.0",
  clock_ms: 5000,
  chapter: "ours",
  robot: {
    url: "sim:lab",
    kind: "SIM",
    name: "lab",
    radius_m: 0.09,
    cruise_m_s: 0.1,
    max_speed_m_s: 0.3,
    max_turn_rate_rad_s: 1.5,
    drives: true,
    dry_run: false,
    capabilities: ["drive", "simulate"],
    failsafe: "",
    lock: "",
    duration_s: null,
    gaps_s: [],
  },
  console: "c1",
  tab: "1",
};

const AT_HOME = {
  x_m: 0,
  y_m: 0,
  heading_rad: 0,
  cov: [
    [1e-4, 0, 0],
    [0, 1e-4, 0],
    [0, 0, 1e-4],
  ],
};

/** @type {State} */
export const STATE = {
  kind: "state",
  seq: 1,
  stamp_s: 1,
  pose: AT_HOME,
  dead_reckoning: AT_HOME,
  velocity: { v_m_s: 0, w_rad_s: 0 },
  landmarks: [],
  slam: {
    mode: "invariant",
    updates: 1,
    nis: 2,
    nis_band: [0.8, 1.2],
    nees: 2.5,
    error_m: 0.01,
    error_rad: 0.01,
    matched: 0,
    ignored: 0,
    tentative: 0,
    update_ms: 1,
    looking_around: false,
  },
  floor: {
    submaps: [],
    closures: [],
    closures_count: 0,
    lost: null,
    match_score: null,
    slipping: false,
    graph_revision: 0,
  },
  map: { name: null, revision: 0, unsaved: false },
  direction: null,
  ears: null,
  person: null,
  goal: null,
  path: [],
  command: null,
  pending_command: null,
  late_command: null,
  camera: null,
  calibration_drift: null,
  robot: {
    url: "sim:lab",
    kind: "SIM",
    name: "lab",
    link: "live",
    age_s: 0.02,
    rate_hz: 40,
    pace: 1,
    contact: false,
    running: true,
    progress: null,
    speed: 1,
    sensors: [],
    timings: [],
    battery: null,
  },
  gate: {
    state: "armed",
    reason: "",
    v_m_s: 0,
    w_rad_s: 0,
    source: "",
    nonce: 1,
    epoch: 1,
    limit_v_m_s: null,
    blocked_by: null,
    need_neutral: false,
  },
  lease: { holder: "Ada", holder_id: "ada-1", epoch: 1, asked_by: null, asked_by_id: null, answer_within_s: null },
  viewers: 1,
  notices: [],
  history_revision: 0,
  truth: null,
};

/** @type {View} */
export const VIEW = {
  hello: HELLO,
  state: STATE,
  link: { is: "up", age_s: 0.05, round_trip_ms: 3, rate_hz: 20, again_s: 0, why: "" },
  up: true,
  lostControl: null,
  restarted: false,
  mine: true,
  permission: { may: "yes", why: "" },
  secure: true,
};
