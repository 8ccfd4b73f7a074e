// Written by `python -m tests.reference`; a test keeps it equal to the code. Do not edit.

import type { State, ClosureRow } from "./messages.js";

/** The accepted calibrations as their files have them; null: as built. */
export interface ActiveCalibrations {
  camera: Record<string, any> | null;
  laser: Record<string, any> | null;
}

/** The detector that looks for people, and the model with which real people are seen. */
export interface ActiveDetector {
  active: string;
  model: string;
  installed: boolean;
  megabytes: number;
  gives: string;
  licence: string;
  look_ms: number | null;
}

/** The orientation in use: who accepted it when, and why it is not used, or ''. */
export interface ActiveOrientationRow {
  yaw_rad: number;
  sd_yaw_rad: number;
  mirrored: boolean;
  residual_rad: number;
  claps: number | null;
  accepted_s: number | null;
  who: string | null;
  verified: boolean;
  not_used: string;
}

/** The engine that reads words, and the model that could read them better. */
export interface ActiveRecognizer {
  active: string;
  model: string;
  installed: boolean;
  megabytes: number;
  gives: string;
  licence: string;
}

/** The result of the newest self-check; `well`: null before the first. */
export interface ArrayCheck {
  busy: boolean;
  well: boolean | null;
  faults: ArrayFault[];
  trouble: string;
}

/** One thing that is wrong, or worth knowing. */
export interface ArrayFault {
  kind: string;
  channels: number[];
  sentence: string;
  serious: boolean;
  values: Record<string, string>;
}

/** The newest events. */
export interface AuditLog {
  entries: HistoryRow[];
}

/** The command that waited, and its number in the history. */
export interface BegunCommand {
  id: number;
  entry: number;
  heard_as: string;
}

/** State of the demonstration in which the simulated person shows how it goes: on or off. */
export interface CalibrationDemo {
  demo: boolean;
}

/** A calibration as its own file in JSON has it; `kind` in what was read from a file. */
export interface CalibrationDocument {
}

/** A topic that could have a role. */
export interface CandidateTopic {
  topic: string;
  type: string;
}

/** A setting after a change, and a sentence for the operator. */
export interface ChangedSetting {
  setting: SettingState;
  sentence: string;
}

/** A figure that the chapter prints, and where ours stands in the result. */
export interface ChapterValue {
  name: string;
  value: number;
  unit: string;
  ours: string;
}

/** The robot's place by the operator. */
export interface ClaimedPlace {
  x_m: number;
  y_m: number;
  heading_rad: number | null;
}

/** A clap: where it was asked for, and where the array heard it. */
export interface ClapRow {
  asked_rad: number;
  heard_rad: number;
  sd_rad: number;
  gap_rad: number | null;
}

/** A clock whose stamps are put on the robot's. */
export interface ClockOffset {
  clock: string;
  offset_s: number;
  ahead_s: number | null;
}

/** New state of a closure. */
export interface ClosureChange {
  closure: number;
  becomes: "undone" | "accepted";
}

/** Every place that was recognised, the oldest first. */
export interface ClosureList {
  closures: ClosureRow[];
}

/** The newest commands; `revision` rises with every change. */
export interface CommandHistory {
  revision: number;
  commands: HistoryRow[];
}

/** A command that began, under its number in the history. */
export interface CommandReceipt {
  id: number;
  command: Record<string, number | string>;
  heard_as: string;
  source: string;
}

/** The command under way. */
export interface CommandReport {
  name: string;
  heard_as: string;
  who: string;
  progress: number | null;
}

/** A figure of the chapter beside ours. */
export interface ComparedFigure {
  name: string;
  unit: string;
  chapter: number;
  ours: number | null;
}

/** The command that does not begin. */
export interface DroppedCommand {
  id: number;
  dropped: boolean;
}

/** All edits of the map in use, and the version of the map: the number of the last edit that holds. */
export interface EditList {
  edits: EditRow[];
  version: number;
}

/** An edit of the map. */
export interface EditRow {
  id: number;
  kind: "free" | "occupied" | "unknown" | "crop" | "turn";
  by: string;
  at_s: number;
  holds: boolean;
  points: number;
  width_m: number;
  angle_rad: number;
}

/** An enrollment, as the page gets it. */
export interface EnrollmentState {
  id: string;
  who: string;
  owner: string;
  background: boolean;
  next: string;
  advice: string;
  gestures: string[];
  pictures: JudgedPictureState[];
  newest: JudgedPictureState | null;
  fewest: number;
  ready: boolean;
  demo: boolean;
  trouble: string;
  waits: string;
}

/** One experiment. */
export interface ExperimentEntry {
  name: string;
  title: string;
  reproduces: string;
  runs: number;
  counts: string;
  base_s: number;
  run_s: number;
  chapter: ChapterValue[];
}

/** All experiments, and all runs. */
export interface ExperimentList {
  experiments: ExperimentEntry[] | null;
  runs: ExperimentRunState[];
}

/** A run as the page shows it. */
export interface ExperimentRunState {
  id: string;
  experiment: string;
  title: string;
  who: string;
  at_s: number;
  runs: number;
  seed: number;
  state: "running" | "done" | "cancelled" | "failed";
  doing: string;
  reason: string;
  progress: number | null;
  took_s: number;
  compared: ComparedFigure[];
  text: string;
  files: ResultFile[];
}

/** The finding of a check. */
export interface Fault {
  code: string;
  sentence: string;
  sensor: string;
  used: boolean;
  values: Record<string, string>;
}

/** Findings of one device. */
export interface Findings {
  base_frame: string;
  roles: TopicRole[];
  placed: string[];
  clocks: ClockOffset[];
  faults: Fault[];
  remarks: string[];
}

/** A file with all that was written to it. */
export interface FinishedRecording {
  name: string;
  seconds: number;
  bytes: number;
  messages: Record<string, number>;
  started_s: number;
  complete: boolean;
  note: string;
  cause: string;
  robot: string;
  code: string | null;
  values: Record<string, string> | null;
  file: string;
}

/** A robot, as the fleet knows it. */
export interface FleetRow {
  robot: string;
  simulated: boolean;
  robot_link: string;
  robot_age_s: number;
  pose: PoseReport | null;
  speed_m_s: number;
  lost: boolean;
  map: MapReport | null;
  battery: number | null;
  operator: string | null;
  command: CommandReport | null;
  gate: string;
  gate_reason: string;
  notice: NoticeReport | null;
  picture: boolean;
  name: string;
  link: "live" | "stale" | "gone";
  age_s: number | null;
  since_s: number;
  need: "unanswered" | "gone" | "stale" | "robot" | "lost" | "halted" | "error" | "blocked" | "battery" | "";
  role: string | null;
  url: string;
}

/** All robots, who needs help first. */
export interface FleetState {
  robots: FleetRow[];
  stop: FleetStopState | null;
  halt: HaltState | null;
  trouble: string;
  time_s: number;
}

/** A stop of all, and who has answered. */
export interface FleetStopState {
  robots: StoppedRobot[];
  all: boolean;
  kind: "stop" | "halt";
  by: string;
  at_s: number;
  asking: boolean;
}

/** The true floor plan as the laser meets it, and what is in the room. */
export interface FloorPlan {
  name: string;
  segments: number[][];
  circles: number[][];
  things: (PlacedThing | PlacedBoard)[];
}

/** Addresses of possible robots. */
export interface FoundAddresses {
  urls: string[];
  looked_at: string[];
}

/** A camera and its mounting; its angles as in a robot file. */
export interface FoundCamera {
  name: string;
  x_m: number;
  y_m: number;
  z_m: number;
  yaw_rad: number;
  pitch_rad: number;
  roll_rad: number;
  mounting: "robot" | "file" | "assumed";
  width: number;
  height: number;
  rate_hz: number | null;
}

/** Findings on the console's robot, and the robot files that were written before. */
export interface FoundConnection {
  connection: FoundRobot;
  why_not: string;
  files: string[];
  opened_here: string[];
}

/** A laser and its mounting. */
export interface FoundLaser {
  name: string;
  x_m: number;
  y_m: number;
  heading_rad: number;
  height_m: number;
  mounting: "robot" | "file" | "assumed";
  beams: number;
  range_max_m: number;
  rate_hz: number | null;
  time_offset_s: number;
}

/** A figure of the body or a limit of speed. */
export interface FoundLimit {
  name: "radius" | "wheelbase" | "cruise" | "max_speed" | "max_turn_rate";
  value: number;
  origin: "robot" | "file" | "assumed";
}

/** A microphone array and its mounting. */
export interface FoundMicrophones {
  name: string;
  x_m: number;
  y_m: number;
  heading_rad: number;
  height_m: number;
  mounting: "robot" | "file" | "assumed";
  microphones: number;
}

/** A device of the robot, by the name of its part of the URL, and its sensors by their names on this robot. */
export interface FoundPart {
  name: string;
  up: boolean;
  drives: boolean;
  lasers: string[];
  cameras: string[];
  microphones: string[];
  findings: Findings;
}

/** All that was found of a robot. */
export interface FoundRobot {
  url: string;
  name: string;
  failsafe: string;
  odometry: boolean;
  limits: FoundLimit[];
  parts: FoundPart[];
  lasers: FoundLaser[];
  cameras: FoundCamera[];
  microphones: FoundMicrophones[];
}

/** True pose of the simulated robot. */
export interface GroundTruth {
  x_m: number;
  y_m: number;
  heading_rad: number;
  stamp_s: number;
  clearance_m: number;
  contact: boolean;
}

/** All are halted, and every robot that comes. */
export interface HaltState {
  by: string;
  since_s: number;
}

/** The robot is halted. */
export interface Halted {
  halted: boolean;
  latched: boolean;
  why?: string;
}

/** Health of the console, and what is wrong. */
export interface HealthReport {
  ok: boolean;
  reasons: string[];
  scene: string;
  pilot_late_ms: Percentiles;
  pilot_step_ms: Percentiles;
}

/** A command or another event: from whom, and how it ended. */
export interface HistoryRow {
  id: number;
  what: string;
  words: string;
  name: string;
  numbers: Record<string, number>;
  heard_as: string;
  source: string;
  who: string;
  role: string;
  state: string;
  remark: string;
  at_s: number;
  ended_s: number | null;
  duration_s: number | null;
  code: string | null;
  values: Record<string, string> | null;
}

/** A picture and what came of it, as the page gets it. */
export interface JudgedPictureState {
  number: number;
  gesture: string;
  good: boolean;
  words: string;
  size: [number, number];
  outline: number[][];
  parts: PersonPart[];
}

/** A key: what it opens, and until when; never the key itself. */
export interface KeyRow {
  id: string;
  name: string;
  role: string;
  kind: "start" | "link" | "file" | "program";
  since_s: number;
  end_s: number | null;
}

/** A person whom the robot knows, and the middle colour of each part of their clothes. */
export interface KnownPerson {
  id: string;
  name: string;
  learnt_s: number;
  by: string;
  pictures: number;
  colours: (string | null)[];
}

/** A scan, seen from the robot. */
export interface LaserPoints {
  stamp_s: number;
  points_m: [number, number][];
}

/** State of listening, and of obeying voices in the room. */
export interface Listening {
  listening: boolean;
  obeying: boolean;
}

/** The name of the map that is being loaded. */
export interface LoadingMap {
  loads: string | null;
}

/** The place of the newer map in the older one: how many of its views `agree`, and what its walls lie on. */
export interface MapMatchRow {
  id: string;
  older: string;
  newer: string;
  x_m: number;
  y_m: number;
  heading_rad: number;
  agree: number;
  of: number;
  links: number;
  overlap: number;
  conflict: number;
}

/** Polygons of the map: each ring x, y, x, y, … in centimetres, world frame. */
export interface MapOutlineRows {
  walls_cm: number[][];
  floor_cm: number[][];
}

/** The map that a robot goes on in: robots whose maps have the same `id` are in one frame. */
export interface MapReport {
  name: string | null;
  id: string;
}

/** Everything that the wizard's page shows. */
export interface MicrophonesState {
  microphones: boolean;
  simulated: boolean;
  busy: boolean;
  listens_s: number;
  asked_rad: number[];
  claps: ClapRow[];
  advice: string;
  verdict: string;
  trouble: string;
  missing: string;
  solution: OrientationRow | null;
  active: ActiveOrientationRow | null;
}

/** A person whom the robot knows. */
export interface NamedPerson {
  id: string;
  name: string;
  pictures: number;
}

/** A link that signs in who opens it. It is shown this once; only its fingerprint is kept. */
export interface NewLink {
  id: string;
  address: string;
  end_s: number;
  qr: string[];
  note: string | null;
}

/** The newest utterances near the robot, and what reads words. */
export interface NewestHearing {
  listening: boolean;
  obeying: boolean;
  microphones: boolean;
  trouble: string;
  engine: string;
  utterances: RoomUtterance[];
}

/** The newest sentence for the operator. */
export interface NoticeReport {
  level: string;
  text: string;
  code: string | null;
  values: Record<string, string> | null;
}

/** The URL that is opened; the console starts again with it, at the same address. */
export interface OpenedRobot {
  url: string;
}

/** How the array is turned on the robot. */
export interface OrientationRow {
  yaw_rad: number;
  sd_yaw_rad: number;
  mirrored: boolean;
  residual_rad: number;
}

/** Size of the robot's own map. */
export interface OwnMapSize {
  width_m: number;
  height_m: number;
}

/** The robot's own navigation. */
export interface OwnNavigationState {
  map: OwnMapSize | null;
  sentence: string;
  shown: boolean;
  pose: PlanarPose | null;
  takes_goals: string;
  goal: PlanarPose | null;
}

/** A parameter of a command, and its bounds. */
export interface ParameterRow {
  name: string;
  says: string;
  unit: string;
  low: number;
  high: number;
  default: number | null;
}

/** Everybody in the simulated room. */
export interface PeopleInRoom {
  people: PersonInRoom[];
}

/** The people and the enrollment under way, as the page gets them. */
export interface PeopleState {
  people: KnownPerson[];
  chosen: string | null;
  enrollment: EnrollmentState | null;
  camera: boolean;
  stands: boolean;
  simulated: boolean;
}

/** How long something takes, usually and at worst [ms]. */
export interface Percentiles {
  p50: number | null;
  p99: number | null;
}

/** A person in the simulated room, and where they really stand in the world frame. */
export interface PersonInRoom {
  id: string;
  x_m: number;
  y_m: number;
  clothes: string;
}

/** A part of a person in a picture. */
export interface PersonPart {
  name: string;
  box_px: [number, number, number, number];
}

/** Whom the console knows behind a request. */
export interface PersonRow {
  id: string;
  name: string;
  role: string;
}

/** Names of the pictures that were taken at stops, the newest first. */
export interface PictureList {
  pictures: string[];
}

/** All places of the map in use. */
export interface PlaceList {
  places: PlaceRow[];
}

/** A named place, where it is now. */
export interface PlaceRow {
  name: string;
  x_m: number;
  y_m: number;
  heading_rad: number | null;
  outline_m: [number, number][];
  wall_m: number | null;
}

/** The chessboard that is held up: its middle, its axes as columns of `rotation`, and its outline. */
export interface PlacedBoard {
  kind: "board";
  id: string;
  what: "board";
  x_m: number;
  y_m: number;
  z_m: number;
  columns: number;
  rows: number;
  square_m: number;
  panel_m: [number, number];
  rotation: number[][];
  outline_m: number[][];
  holder: string | null;
  fixed: boolean;
  seconds?: number;
}

/** A thing or a person in the room. Only a person has clothes and a gesture, and only one who walks a path. */
export interface PlacedThing {
  kind: "thing";
  id: string;
  what: string;
  x_m: number;
  y_m: number;
  heading_rad: number;
  length_m: number;
  depth_m: number;
  height_m: number;
  fixed: boolean;
  clothes?: string;
  gesture?: string;
  path_m?: [number, number][];
  speed_m_s?: number;
  again?: boolean;
}

/** A pose on a map. */
export interface PlanarPose {
  x_m: number;
  y_m: number;
  heading_rad: number;
}

/** How a recording plays, and what happened in it. */
export interface PlaybackDescription {
  t_s: number;
  duration_s: number;
  playing: boolean;
  speed: number;
  way: string;
  compare: boolean;
  ways: string[];
  computed_since_s: number | null;
  marks: PlaybackMark[];
}

/** Something that happened in a recording. */
export interface PlaybackMark {
  t_s: number;
  kind: string;
  text: string;
}

/** The pose that a robot takes itself to have, in the frame of its map. */
export interface PoseReport {
  x_m: number;
  y_m: number;
  heading_rad: number;
}

/** The point of the floor that a pixel shows, in the world; without one, `why` says why. */
export interface PressedFloor {
  x_m: number | null;
  y_m: number | null;
  distance_m: number | null;
  ring_px: [number, number][];
  why: string;
  code: string | null;
  values: Record<string, string> | null;
}

/** The figures of one place; those that are unset were not measured. */
export interface QualityRow {
  distance_m: number;
  snr_db: number;
  refused: string;
  stoi?: number | null;
  estoi?: number | null;
  si_sdr_db?: number | null;
  words?: number;
  erroneous_words_person?: number;
  erroneous_words_robot?: number;
  osqe_d?: number | null;
  osqe_r?: number | null;
  reason?: string | null;
  verdict?: string | null;
  commands?: number;
  commands_exact?: number;
}

/** All runs, and why another one cannot begin. */
export interface QualityRunList {
  runs: QualityRunState[];
  why_not: string;
}

/** A run as the page shows it. */
export interface QualityRunState {
  id: string;
  who: string;
  at_s: number;
  setup: QualitySetup;
  state: "running" | "done" | "cancelled" | "failed";
  doing: string;
  reason: string;
  progress: number;
  voice: string;
  rows: QualityRow[];
  reports: boolean[];
  summary: string;
}

/** Measurements: every pair of a distance and a ratio, from where the robot stands in the world. */
export interface QualitySetup {
  world: string;
  x_m: number;
  y_m: number;
  heading_rad: number;
  towards_rad: number;
  distances_m: number[];
  snr_db: number[];
  phrases: number;
}

/** The recorder now, and every recording, the newest first. */
export interface RecordingList {
  recorder: RecordingState;
  recordings: FinishedRecording[];
}

/** The recorder as the page shows it. */
export interface RecordingState {
  name: string | null;
  path: string;
  seconds: number;
  bytes: number;
  started_s: number;
  messages: Record<string, number>;
  ring_s: number;
}

/** The thing that was taken away. */
export interface RemovedThing {
  id: string;
}

/** The halt is lifted. */
export interface ResetHalt {
  halted: boolean;
}

/** A file of a run. */
export interface ResultFile {
  name: string;
  bytes: number;
  figure: boolean;
}

/** An utterance near the robot. */
export interface RoomUtterance {
  id: number;
  t0_s: number;
  t1_s: number;
  words: string;
  accepted: boolean;
  command: string | null;
  reason: string;
  azimuth_rad: number | null;
  sd_rad: number | null;
  verdict: "accept" | "confirm" | "reject";
  confidence: number;
  suggested_commands: string[];
}

/** All routes of the map in use. */
export interface RouteList {
  routes: RouteMark[];
}

/** Places in the order in which they are driven to. */
export interface RouteMark {
  name: string;
  stops: RouteStop[];
  loop: boolean;
  begins: string;
  ends: string;
  every_min: number;
}

/** An event at a stop. */
export interface RouteNote {
  at_s: number;
  stop: number;
  place: string;
  state: string;
  remark: string;
  picture: string;
}

/** The route under way, or the last one. */
export interface RouteProgress {
  name: string | null;
  stop: number;
  of: number;
  state: "idle" | "driving" | "waiting" | "paused" | "ended";
  reason: string;
  round: number;
  place: string;
  owner: string;
  skipped: number;
  notes: RouteNote[];
}

/** A stop of a route. */
export interface RouteStop {
  place: string;
  wait_s: number;
  action: "wait_for_continue" | "come_here" | "say" | "take_a_picture" | "record" | null;
  text: string;
}

/** All saved maps, the newest first, and the name of the one that the robot goes on in. */
export interface SavedMapList {
  current: string | null;
  maps: SavedMapRow[];
}

/** A saved map; `verified`: it bears checksums, which are compared when it is loaded or packed. */
export interface SavedMapRow {
  name: string;
  saved_s: number;
  by: string;
  robot: string;
  resolution_m: number;
  width_m: number;
  height_m: number;
  submaps: number;
  landmarks: number;
  closures: number;
  verified: boolean;
}

/** The type as which speeds are sent. */
export interface SentSpeeds {
  type: "Twist" | "TwistStamped";
}

/** All sessions, the newest first. */
export interface SessionList {
  sessions: SessionRow[];
}

/** A session in the list of all. */
export interface SessionRow {
  id: string;
  kind: "camera" | "laser";
  source: "robot" | "upload" | "webcam";
  created_s: number;
  views: number;
  ready: boolean;
  accepted: boolean;
  accepted_s: number | null;
}

/** One common setting, as it is declared and as it holds. */
export interface SettingState {
  section: string;
  name: string;
  kind: string;
  unit: string;
  low: number | null;
  high: number | null;
  choices: string[];
  meaning: string;
  watch: string;
  default: boolean | number | number | string;
  value: boolean | number | number | string;
  saved: boolean | number | number | string;
  live: boolean;
}

/** All common settings. */
export interface SettingsState {
  file: string;
  restart: boolean;
  settings: SettingState[];
}

/** All logins and keys, eldest first. */
export interface SignInList {
  sessions: SignedIn[];
  keys: KeyRow[];
}

/** A browser that is signed in. */
export interface SignedIn {
  id: string;
  name: string;
  role: string;
  since_s: number;
  end_s: number;
  present: boolean;
  yours: boolean;
}

/** The login is over. */
export interface SignedOut {
  signed_out: boolean;
}

/** The sound of a text. */
export interface SpokenAnswer {
  id: number;
  seconds: number;
  rate_hz: number;
  pcm: string;
}

/** Whose mouth speaks, where, for how long, and whether the robot obeys voices in the room now. */
export interface SpokenInRoom {
  id: string;
  seconds: number;
  x_m: number;
  y_m: number;
  obeyed: boolean;
  note: string;
}

/** A recording that has begun. */
export interface StartedRecording {
  name: string;
  path: string;
  started_s: number;
}

/** The action that was done, and the recording that an export has made. */
export interface SteeredPlayback {
  done: "play" | "pause" | "seek" | "speed" | "way" | "export";
  recording: FinishedRecording | null;
}

/** The robot stands. */
export interface Stopped {
  stopped: boolean;
}

/** A robot's answer to a stop of all. */
export interface StoppedRobot {
  name: string;
  acknowledged: boolean;
  ms: number | null;
  gate_ms: number | null;
  link: "live" | "stale" | "gone";
  reason: string;
}

/** A map that was taken in; `remark`: a sentence on what in its files may be meant otherwise, "" for none. */
export interface TakenMap {
  name: string;
  saved_s: number;
  by: string;
  robot: string;
  resolution_m: number;
  width_m: number;
  height_m: number;
  submaps: number;
  landmarks: number;
  closures: number;
  verified: boolean;
  remark: string;
}

/** A recording that was kept, and what opens it. */
export interface TakenRecording {
  url: string;
}

/** A role and the topics that have it now; `candidates` are all that could, these among them. */
export interface TopicRole {
  role: "odometry" | "scan" | "image" | "camera_info" | "sound" | "cmd_vel" | "battery" | "map" | "pose" | "frames" | "description";
  used: UsedTopic[];
  candidates: CandidateTopic[];
  most: number;
  remark: string;
}

/** A topic that has a role, and what comes on it. */
export interface UsedTopic {
  topic: string;
  type: string;
  frame: string;
  rate_hz: number | null;
  age_s: number | null;
  guessed: boolean;
}

/** Table 2. */
export interface Vocabulary {
  commands: VocabularyRow[];
}

/** A row of Table 2. */
export interface VocabularyRow {
  name: string;
  words: string[];
  example: string;
  summary: string;
  icon: string;
  target: string;
  endless: boolean;
  numbers: ParameterRow[];
}

/** State of muting: nobody is listened to while the robot speaks. */
export interface VoiceState {
  muted: boolean;
}

/** A robot file on the disk. */
export interface WrittenFile {
  name: string;
  path: string;
  command: string;
  text: string;
}

/** All zones of the map in use. */
export interface ZoneList {
  zones: ZoneRow[];
}

/** A zone, where it is now. */
export interface ZoneRow {
  name: string;
  kind: "keep_out" | "slow";
  points_m: [number, number][];
  max_speed_m_s: number | null;
}

/** The zones that were drawn of a mask; `left_out`: a sentence on cells that became none, "" for none. */
export interface ZonesOfMask {
  zones: ZoneRow[];
  left_out: string;
}
