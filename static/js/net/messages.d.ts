// Written by `python -m tests.reference`; a test keeps it equal to the code. Do not edit.

/** Comes back as it is: the page measures how long that takes. */
export interface EchoMessage {
  kind: "echo";
  t: number;
}

/** Latch a stop. `press` as of `StopMessage`. */
export interface HaltMessage {
  kind: "halt";
  press?: number;
}

/** Undo the latch; never moves. */
export interface HaltResetMessage {
  kind: "halt_reset";
  ref: number;
}

/** Hold to drive: sent at 20 Hz while a key or the pad is held. `press` is drawn again with every press. */
export interface JogMessage {
  kind: "drive";
  v: number;
  w: number;
  press: number;
  seq: number;
  nonce: number;
  epoch: number;
}

/** Take control, take it over, give it back; ask who has it; the answer to who asks: give or keep. `leave`: this page is left; control is given back unless the same person has another page open. */
export interface LeaseMessage {
  kind: "lease";
  do: "acquire" | "take" | "release" | "leave" | "ask" | "give" | "keep";
  ref: number;
}

/** Speech follows: until `rest` (the button is held), or cut into utterances by its silences (open). `seen`: `seq` of the newest state that the page has (0: none), which dates the sound that is sent next. `speaker`, in the simulator: the sound comes from the mouth of this person in the room, "nearest" for the nearest one in sight; "", or nobody there: it comes from no place in the room. */
export interface Listen {
  kind: "listen";
  mode: "held" | "open";
  seen?: number;
  speaker?: string;
}

/** Steer a recording: `t_s` [s] from its start is the place to seek, `speed` is in times real time. `way` shows what was recorded, or what is computed now; with `compare` one over the other. */
export interface PlaybackMessage {
  kind: "playback";
  action: "play" | "pause" | "seek" | "speed" | "way";
  ref: number;
  t_s?: number | null;
  speed?: number | null;
  way?: "recorded" | "computed" | null;
  compare?: boolean;
}

/** The button was let go, or the microphone closed. */
export interface Rest {
  kind: "rest";
}

/** Words for the robot. `seen`: `seq` of the newest state that the page has (0: none), which dates them. */
export interface SayMessage {
  kind: "command";
  text: string;
  source: "typed" | "chip" | "click" | "camera";
  ref: number;
  seen?: number;
}

/** Everything cancelled, zero speed. `press` (0: none): its copy over HTTP is recorded once. */
export interface StopMessage {
  kind: "stop";
  press?: number;
}

/** Subscriptions of this socket: the camera, and a calibration session (null: none); what is left out stays. */
export interface SubscriptionMessage {
  kind: "want";
  camera?: boolean;
  calibration?: string | null;
}

/** All that goes up to the console. */
export type Up = JogMessage | StopMessage | SayMessage | LeaseMessage | HaltMessage | HaltResetMessage | PlaybackMessage | SubscriptionMessage | EchoMessage;

/** All that was said in a turn has been read: no words of it come any more. */
export interface AllRead {
  kind: "read";
}

/** The result of a message that carried `ref`; 0 when it carried none. */
export interface AnswerMessage {
  kind: "answer";
  ref: number;
  ok: boolean;
  status: number;
  detail?: string | null;
  suggestions?: string[] | null;
  id?: number | null;
  code?: string | null;
  values?: Record<string, string> | null;
}

/** One part of a person's rectangle in the picture. */
export interface BodyPart {
  name: "head" | "torso" | "feet";
  likelihood: number | null;
  box_px: [number, number, number, number];
}

/** The next view to take. */
export interface CalibrationAdvice {
  words: string;
  outline: [number, number][];
  corners: [number, number][];
}

/** How far the views span place, size and skew, 0..1. */
export interface CalibrationBars {
  x: number;
  y: number;
  size: number;
  skew: number;
}

/** The chessboard, counted in inner corners. */
export interface CalibrationBoard {
  columns: number;
  rows: number;
  square_m: number;
  panel_m: [number, number] | null;
}

/** How the solution predicted a pose that had no part in it. */
export interface CalibrationCheck {
  name: string;
  off_px: number;
  residual_rms_m: number;
  beams: number;
  words: string;
}

/** How the camera's mount seems to differ from the calibration in use. */
export interface CalibrationDriftState {
  turn_rad: number;
  turn_sd_rad: number;
  apparent_rad: number;
  apparent_sd_rad: number;
  shift_m: number;
  shift_sd_m: number;
  pairs: number;
  corners: number;
  alarm: boolean;
  words: string;
}

/** A session has changed; sent whole, the newest only, at most ten times a second (a counted view at once). */
export interface CalibrationNews {
  kind: "calibration";
  session: CalibrationSessionState;
}

/** How far the wizard is; the lower keys belong to one kind of session only. */
export interface CalibrationProgress {
  views: number;
  ready: boolean;
  words: string;
  p95_px: number | null;
  target_px: number | null;
  bars: CalibrationBars | null;
  cells: number[][] | null;
  precision: Record<string, number> | null;
  weak: string[] | null;
  laser_offset: string | null;
  from_ruler: Record<string, string> | null;
  known_from: number | null;
}

/** The laser's newest scan in its own frame [m]; `board` are indices of `points`. */
export interface CalibrationScan {
  points: [number, number][];
  background: [number, number][];
  board: number[];
}

/** Everything about one calibration. */
export interface CalibrationSessionState {
  id: string;
  kind: "camera" | "laser";
  source: "robot" | "upload" | "webcam";
  board: CalibrationBoard;
  created_s: number;
  height_m: number | null;
  size: [number, number] | null;
  live: boolean;
  demo: boolean;
  verdict: CalibrationVerdict | null;
  advice: CalibrationAdvice | null;
  progress: CalibrationProgress;
  uncertainty: CalibrationUncertainty | null;
  views: CalibrationView[];
  solving: CalibrationSolving | null;
  solution: Record<string, any> | null;
  check: CalibrationCheck | null;
  accepted_s: number | null;
  active_compare: Record<string, [number, number]> | null;
  scan: CalibrationScan | null;
}

/** A solution is being made. */
export interface CalibrationSolving {
  since_s: number;
  words: string;
}

/** Standard deviation of the projection over the picture, row by row. */
export interface CalibrationUncertainty {
  columns: number;
  rows: number;
  sd_px: ((number | null)[])[];
}

/** The verdict on one picture or scan; `number` counts them. */
export interface CalibrationVerdict {
  kind: "nothing" | "refused" | "moving" | "same" | "counted" | "background" | "gathering" | "trouble";
  words: string;
  name: string;
  number: number;
  corners: [number, number][] | null;
  laser: [number, number, number, boolean][] | null;
  beams: number[] | null;
  stamp_s: number | null;
}

/** A view or a pose in the session. */
export interface CalibrationView {
  name: string;
  dropped: boolean;
  rms_px: number | null;
  rms_m: number | null;
  used: boolean | null;
  reason: string;
}

/** The outlines that perception drew on the newest picture, and the planned way on its floor. */
export interface CameraOverlay {
  stamp_s: number;
  width: number;
  height: number;
  edges: EdgeLine[];
  laser: [number, number, number][];
  quality: PictureQualityState | null;
  way?: [number, number, number][][];
  goal?: [number, number][];
}

/** A pose of the world frame where the robot may be. */
export interface CandidateState {
  x_m: number;
  y_m: number;
  heading_rad: number;
}

/** A place that was recognised. */
export interface ClosureRow {
  id: number;
  stamp_s: number;
  submap_from: number;
  submap_to: number;
  position_from: PlaceState;
  position_to: PlaceState;
  score: number;
  state: "accepted" | "undone" | "doubtful";
  words: string;
}

/** A command and how it goes. */
export interface CommandState {
  id: number;
  name: string;
  numbers: Record<string, number>;
  heard_as: string;
  source: string;
  who: string;
  state: "running" | "done" | "refused" | "cancelled" | "pre-empted" | "failed";
  remark: string;
  progress: number | null;
  code?: string | null;
  values?: Record<string, string> | null;
}

/** The other way of a recording beside the one that is shown, in its world, and the difference in numbers. */
export interface ComparisonState {
  pose: TruePose;
  trail: [number, number][];
  landmarks: [number, number][];
  distance_m: number;
  turn_rad: number;
  worst_m: number;
  recorded_landmarks: number;
  computed_landmarks: number;
  recorded_edges: number;
  computed_edges: number;
  direction_rad: number | null;
  frames: number;
  same: boolean;
}

/** The same number back: measures the link. */
export interface EchoBack {
  kind: "echo";
  t: number;
}

/** A vertical edge in the newest picture, in pixels. */
export interface EdgeLine {
  u0: number;
  v0: number;
  u1: number;
  v1: number;
  bearing_rad: number;
  matched: boolean;
}

/** The setpoint that the gate lets through. */
export interface GateState {
  state: string;
  reason: string;
  v_m_s: number;
  w_rad_s: number;
  source: string;
  nonce: number;
  epoch: number;
  limit_v_m_s: number | null;
  blocked_by: PointState | null;
  need_neutral: boolean;
  code?: string | null;
  values?: Record<string, string> | null;
}

/** The state of the robot's hearing. */
export interface HearingState {
  listening: boolean;
  muted: boolean;
  voice_control: boolean;
  starting: boolean;
  suggested_commands: string[];
  speaking: boolean;
  level_dbfs: number | null;
  voices: VoiceHeard[];
}

/** The first message of a socket. */
export interface HelloMessage {
  kind: "hello";
  you: You;
  version: string;
  robot: RobotCard;
  console: string;
  tab: string;
  clock_ms: number;
  chapter: "ours" | "printed";
}

/** A row of the paper's table L. */
export interface LandmarkRow {
  id: number;
  x_m: number;
  y_m: number;
  cov_m2: number[][];
  hits: number;
  misses: number;
  kind: string;
}

/** The pose by laser and wheels alone, beside the one by all senses. */
export interface LaserReferenceState {
  pose: PoseState;
  distance_m: number;
  turn_rad: number;
}

/** The time offset between a laser and the odometry, estimated from turns. */
export interface LaserTiming {
  laser: string;
  offset_s: number;
  sd_s: number;
  applied_s: number;
}

/** A spoken command that was refused because it came too late; it begins as a pending command does. */
export interface LateCommandState {
  id: number;
  heard_as: string;
}

/** The lease: the operator who drives. */
export interface LeaseState {
  holder: string | null;
  holder_id: string | null;
  epoch: number;
  asked_by: string | null;
  asked_by_id: string | null;
  answer_within_s: number | null;
}

/** `on`: words are read now; otherwise the reason why not. */
export interface ListeningMessage {
  kind: "listening";
  on: boolean;
  why: string;
}

/** The robot does not know where it is. */
export interface LocalizationState {
  phase: "searching" | "confirming" | "asking";
  words: string;
  since_s: number;
  candidates: CandidateState[];
}

/** Which saved map the robot goes on in. */
export interface MapState {
  name: string | null;
  revision: number;
  unsaved: boolean;
  marks: number;
}

/** Moves of the robot by its wheels over those by its scans, as far as it has moved. */
export interface MoveAgreementState {
  laser: string;
  turns: number;
  ways: number;
  turn_scale: number | null;
  turn_scale_sd: number | null;
  way_scale: number | null;
  way_scale_sd: number | null;
}

/** A sentence for the operator. */
export interface NoticeLine {
  id: number;
  stamp_s: number;
  at_s: number;
  level: "info" | "warning" | "error";
  text: string;
  cause?: string;
  code?: string | null;
  values?: Record<string, string> | null;
}

/** The words so far of a sentence under way; they mean nothing yet. */
export interface PartialTranscript {
  kind: "partial";
  words: string;
}

/** A spoken command that was understood and has not begun, and its preview as the robot stands now. */
export interface PendingCommandState {
  id: number;
  name: string;
  numbers: Record<string, number>;
  heard_as: string;
  source: string;
  who: string;
  begins_in_s: number;
  delay_s: number;
  target: "none" | "place" | "person";
  confidence: number;
  uncertain: boolean;
  alternatives: string[];
  way: [number, number][];
  goal: [number, number] | null;
  heading_rad: number | null;
  bearing_rad: number | null;
  bearing_sd_rad: number | null;
}

/** The person whom the running command follows: by every sense alone, and by all together. */
export interface PersonState {
  state: "seen" | "hidden";
  age_s: number;
  x_m: number;
  y_m: number;
  cov_m2: number[][];
  used: ("laser" | "camera" | "sound")[];
  laser: [number, number] | null;
  camera: SensedBearing | null;
  sound: SensedBearing | null;
  value: number | null;
  parts: BodyPart[];
  landmarks_px: ([number, number] | null)[];
  picture_age_s: number | null;
  centre_px: [number, number] | null;
  name: string;
}

/** How good the newest picture is, and how it was corrected; grey levels are 0..255. */
export interface PictureQualityState {
  state: "good" | "mended" | "poor" | "unusable";
  label: string;
  words: string;
  mean: number;
  low: number;
  high: number;
  dark_share: number;
  bright_share: number;
  noise_sd: number;
  snr_db: number;
  blur_px: number | null;
  blur_down_px: number | null;
  margin: number;
  gain: number;
  gamma: number;
  contrast: number;
  smoothing: number;
}

/** A point of the world frame. */
export interface PlaceState {
  x_m: number;
  y_m: number;
}

/** A recording of Beckon's own: the ways in which it is shown. */
export interface PlaybackView {
  way: string;
  compare: boolean;
  ways: string[];
  computed_since_s: number | null;
  reached_speed: number | null;
  comparison: ComparisonState | null;
}

/** A point of the world frame. */
export interface PointState {
  x_m: number;
  y_m: number;
}

/** A pose of the world frame and its covariance. */
export interface PoseState {
  x_m: number;
  y_m: number;
  heading_rad: number;
  cov: number[][];
}

/** The recorder, and what it holds in memory. */
export interface RecorderState {
  name: string | null;
  seconds: number;
  bytes: number;
  ring_s: number;
  ring_limit_s: number;
  revision: number;
}

/** The description of the robot. */
export interface RobotCard {
  url: string;
  kind: "SIM" | "LOG" | "LIVE";
  name: string;
  radius_m: number;
  camera_view_rad: [number, number] | null;
  cruise_m_s: number;
  max_speed_m_s: number;
  max_turn_rate_rad_s: number;
  drives: boolean;
  dry_run: boolean;
  capabilities: ("drive" | "simulate" | "replay" | "results" | "navigate")[];
  failsafe: string;
  lock: string;
  duration_s: number | null;
  gaps_s: [number, number][];
}

/** The robot and the link to it. */
export interface RobotState {
  url: string;
  kind: "SIM" | "LOG" | "LIVE";
  name: string;
  link: "connecting" | "live" | "stale" | "lost";
  age_s: number | null;
  rate_hz: number;
  pace: number;
  contact: boolean;
  running: boolean;
  progress: number | null;
  speed: number;
  sensors: SensorLine[];
  timings: LaserTiming[];
  agreement: MoveAgreementState | null;
  battery: number | null;
}

/** The route that runs, or the last one. */
export interface RouteUnderWay {
  name: string;
  place: string;
  stop: number;
  of: number;
  state: "idle" | "driving" | "waiting" | "paused" | "ended";
  reason: string;
  noted_at_s: number | null;
  code: string | null;
  values: Record<string, string> | null;
}

/** A bearing of a person, with the point from which they are seen or heard. */
export interface SensedBearing {
  x_m: number;
  y_m: number;
  azimuth_world_rad: number;
  sd_rad: number;
}

/** A sensor of the robot, and whether it delivers. */
export interface SensorLine {
  kind: "wheels" | "laser" | "camera" | "microphones";
  name: string;
  state: "live" | "stale" | "lost";
  age_s: number;
  rate_hz: number;
}

/** How the filter fares. */
export interface SlamState {
  mode: string;
  updates: number;
  nis: number | null;
  nis_band: [number, number];
  nees: number | null;
  error_m: number | null;
  error_rad: number | null;
  matched: number;
  ignored: number;
  tentative: number;
  update_ms: number | null;
  looking_around: boolean;
}

/** Everything that may be shown at one instant; the newest replaces the older. */
export interface State {
  kind: "state";
  seq: number;
  stamp_s: number;
  pose: PoseState;
  dead_reckoning: PoseState;
  velocity: Velocity;
  landmarks: LandmarkRow[];
  slam: SlamState;
  floor: SubmapsState;
  map: MapState;
  direction: VoiceHeard | null;
  ears: HearingState | null;
  person: PersonState | null;
  goal: PointState | null;
  path: [number, number][];
  command: CommandState | null;
  pending_command: PendingCommandState | null;
  late_command: LateCommandState | null;
  camera: CameraOverlay | null;
  calibration_drift: CalibrationDriftState | null;
  robot: RobotState;
  gate: GateState;
  lease: LeaseState;
  recording: RecorderState | null;
  playback: PlaybackView | null;
  viewers: number;
  notices: NoticeLine[];
  history_revision: number;
  truth: TruePose | null;
  by_laser: LaserReferenceState | null;
  route: RouteUnderWay | null;
  chapter: "ours" | "printed";
}

/** A room as the map has it. */
export interface SubmapRow {
  id: number;
  x_m: number;
  y_m: number;
  heading_rad: number;
  extent_m: [number, number, number, number];
  active: boolean;
}

/** How the scan layer fares. */
export interface SubmapsState {
  submaps: SubmapRow[];
  closures: ClosureRow[];
  closures_count: number;
  lost: LocalizationState | null;
  match_score: number | null;
  slipping: boolean;
  graph_revision: number;
}

/** Words that were heard, and what came of them. */
export interface Transcript {
  kind: "transcript";
  id: number;
  words: string;
  final: boolean;
  accepted: boolean;
  heard_as: string;
  reason: string;
  suggestions: string[];
  confidence: number;
  seconds: number;
  delay_s: number;
  entry: number | null;
  pending_command: number | null;
  code: string | null;
  values: Record<string, string> | null;
}

/** The true pose of the simulated robot. */
export interface TruePose {
  x_m: number;
  y_m: number;
  heading_rad: number;
}

/** Speeds as the wheels report them. */
export interface Velocity {
  v_m_s: number;
  w_rad_s: number;
}

/** A voice and its direction, as heard from the robot. */
export interface VoiceHeard {
  id: number;
  azimuth_rad: number;
  azimuth_world_rad: number;
  sd_rad: number;
  sd_heard_rad: number;
  elevation_rad: number | null;
  ambiguity: string;
  strength: number;
  age_s: number;
  x_m: number;
  y_m: number;
  columns_px: [number, number, number] | null;
}

/** The person a socket belongs to. */
export interface You {
  name: string;
  role: "viewer" | "operator" | "admin";
  id: string;
}

/** All that comes down to the browser. */
export type Down = HelloMessage | State | CalibrationNews | AnswerMessage | EchoBack;
