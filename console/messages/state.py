"""The state message, and everything else that goes down the socket `/ws` to a browser.

Keys carry their unit. What is not a finite number leaves as null.
"""

import struct
from typing import Literal

import msgspec

from console.messages.calibration import CalibrationNews
from console.messages.hearing import HearingState, VoiceHeard
from console.messages.map import MapState, SubmapsState
from console.messages.person import PersonState
from console.messages.picture import CalibrationDriftState, PictureQualityState
from core.commands.command import Target
from core.robots import Capability, RobotKind
from core.sentences import plain
from core.snapshot import Ending, Level, SensorKind, SensorState

Struct = msgspec.Struct

CAMERA_HEADER = struct.Struct("<BxxxId")  # kind = 1, sequence number, stamp [s]; the JPEG follows


class PointState(Struct):
    """A point of the world frame."""

    x_m: float
    y_m: float


class PoseState(Struct):
    """A pose of the world frame and its covariance."""

    x_m: float
    y_m: float
    heading_rad: float
    cov: list[list[float]]  # 3x3 of x, y, heading


class TruePose(Struct):
    """The true pose of the simulated robot."""

    x_m: float
    y_m: float
    heading_rad: float


class Velocity(Struct):
    """Speeds as the wheels report them."""

    v_m_s: float
    w_rad_s: float


class LandmarkRow(Struct):
    """A row of the paper's table L."""

    id: int
    x_m: float
    y_m: float
    cov_m2: list[list[float]]  # 2x2
    hits: int
    misses: int
    kind: str


class SlamState(Struct):
    """How the filter fares."""

    mode: str
    updates: int
    nis: float | None
    nis_band: tuple[float, float]  # within which it lies 95 % of the time when all is well
    nees: float | None  # the same of the pose's true error, ideal mean 3; only where the truth is known
    error_m: float | None  # how far the estimate lies from the truth; simulator only
    error_rad: float | None
    matched: int
    ignored: int
    tentative: int
    update_ms: float | None
    looking_around: bool


class CommandPayload(Struct):
    id: int
    name: str
    numbers: dict[str, float]
    heard_as: str
    source: str
    who: str


class PendingCommandState(CommandPayload):
    """A spoken command that was understood and has not begun, and its preview as the robot stands now."""

    begins_in_s: float
    delay_s: float  # that it waits in all
    target: Target
    confidence: float  # 0 to 1 that the words are right
    uncertain: bool  # a number in it may have been another: the decision was to confirm it
    alternatives: list[str]  # the commands that it may have been, the likeliest first
    way: list[tuple[float, float]]  # in the world frame; a straight line or an arc, not a plan
    goal: tuple[float, float] | None  # in the world frame
    heading_rad: float | None  # to which it would turn; world
    bearing_rad: float | None  # of who spoke, in the robot's frame as it stands now
    bearing_sd_rad: float | None


class LateCommandState(Struct):
    """A spoken command that was refused because it came too late; it begins as a pending command does."""

    id: int
    heard_as: str


class CommandState(CommandPayload, omit_defaults=True):
    """A command and how it goes."""

    state: Ending
    remark: str
    progress: float | None
    code: str | None = None  # of the sentence in `remark`, which keeps its meaning in every language
    values: dict[str, str] | None = None  # in that sentence, by their names


class RouteUnderWay(Struct):
    """The route that runs, or the last one."""

    name: str
    place: str  # of the stop that is driven to, or stood at
    stop: int  # its number, from 1
    of: int
    state: Literal["idle", "driving", "waiting", "paused", "ended"]
    reason: str  # a sentence: why it stands, or ended
    noted_at_s: float | None  # Unix time of what was noted last at a stop; the notes are with GET /api/route
    code: str | None = None  # of the sentence in `reason`
    values: dict[str, str] | None = None


class EdgeLine(Struct):
    """A vertical edge in the newest picture, in pixels."""

    u0: float
    v0: float
    u1: float
    v1: float
    bearing_rad: float
    matched: bool


class CameraOverlay(Struct, omit_defaults=True):
    """The outlines that perception drew on the newest picture, and the planned way on its floor."""

    stamp_s: float
    width: int
    height: int
    edges: list[EdgeLine]
    laser: list[tuple[float, float, float]]  # u, v [pixel], range [m]
    quality: PictureQualityState | None
    way: list[list[tuple[float, float, float]]] = []  # what of it is in sight: u, v [pixel], distance [m]
    goal: list[tuple[float, float]] = []  # a ring around it: u, v [pixel]


class SensorLine(Struct):
    """A sensor of the robot, and whether it delivers."""

    kind: SensorKind
    name: str
    state: SensorState
    age_s: float
    rate_hz: float


class LaserTiming(Struct):
    """The time offset between a laser and the odometry, estimated from turns."""

    laser: str
    offset_s: float  # to add to its stamps; positive: they are early
    sd_s: float
    applied_s: float  # that are added now


class MoveAgreementState(Struct):
    """Moves of the robot by its wheels over those by its scans, as far as it has moved."""

    laser: str
    turns: int  # moves that show a turn
    ways: int  # moves that show a way
    turn_scale: float | None  # the wheels' turn over the scans'; less than 0: mirrored; null: too few show it
    turn_scale_sd: float | None
    way_scale: float | None
    way_scale_sd: float | None


class RobotState(Struct):
    """The robot and the link to it."""

    url: str
    kind: RobotKind
    name: str
    link: Literal["connecting", "live", "stale", "lost"]
    age_s: float | None
    rate_hz: float
    pace: float  # share of real time at which its clock runs; less than 1: its computer is too slow for it
    contact: bool
    running: bool
    progress: float | None
    speed: float
    sensors: list[SensorLine]
    timings: list[LaserTiming]  # of the lasers whose time offset is known
    agreement: MoveAgreementState | None  # of wheels and scans
    battery: float | None


class GateState(Struct, omit_defaults=True):
    """The setpoint that the gate lets through."""

    state: str  # disarmed | armed | halted
    reason: str
    v_m_s: float
    w_rad_s: float
    source: str
    nonce: int
    epoch: int
    limit_v_m_s: float | None
    blocked_by: PointState | None
    need_neutral: bool
    code: str | None = None  # of the sentence in `reason`, which keeps its meaning in every language
    values: dict[str, str] | None = None  # in that sentence, by their names


class RecorderState(Struct):
    """The recorder, and what it holds in memory."""

    name: str | None  # of the recording that runs
    seconds: float
    bytes: int
    ring_s: float  # [s] that can be kept now
    ring_limit_s: float  # [s] at most; 0: nothing is held
    revision: int  # grows whenever the list of recordings has changed


class ComparisonState(Struct):
    """The other way of a recording beside the one that is shown, in its world, and the difference in numbers."""

    pose: TruePose
    trail: list[tuple[float, float]]  # x, y [m], thinned
    landmarks: list[tuple[float, float]]
    distance_m: float  # between the two poses now
    turn_rad: float
    worst_m: float  # the largest distance since computing began
    recorded_landmarks: int
    computed_landmarks: int
    recorded_edges: int  # in the newest picture
    computed_edges: int
    direction_rad: float | None  # between the voices that were heard last
    frames: int  # that were compared
    same: bool  # every pose, edge, direction and map until now, to the last bit


class PlaybackView(Struct):
    """A recording of Beckon's own: the ways in which it is shown."""

    way: str  # "recorded" | "computed"
    compare: bool
    ways: list[str]
    computed_since_s: float | None  # from its start
    reached_speed: float | None  # times real time, where computing is slower than what was asked for
    comparison: ComparisonState | None


class LeaseState(Struct):
    """The lease: the operator who drives."""

    holder: str | None
    holder_id: str | None
    epoch: int
    asked_by: str | None = None  # another operator, who asks the holder for control
    asked_by_id: str | None = None
    answer_within_s: float | None = None  # then the request ends by itself


class NoticeLine(Struct, omit_defaults=True):
    """A sentence for the operator."""

    id: int
    stamp_s: float  # the robot's clock
    at_s: float  # Unix time
    level: Level
    text: str
    cause: str = ""  # what it is about: of one cause only the newest is shown
    code: str | None = None  # of the sentence in `text`, which keeps its meaning in every language
    values: dict[str, str] | None = None  # in that sentence, by their names


class LaserReferenceState(Struct):
    """The pose by laser and wheels alone, beside the one by all senses."""

    pose: PoseState
    distance_m: float  # between the two
    turn_rad: float  # this heading minus the other


class State(Struct, tag_field="kind", tag="state"):
    """Everything that may be shown at one instant; the newest replaces the older."""

    seq: int
    stamp_s: float
    pose: PoseState
    dead_reckoning: PoseState
    velocity: Velocity
    landmarks: list[LandmarkRow]
    slam: SlamState
    floor: SubmapsState
    map: MapState
    direction: VoiceHeard | None  # the voice that was heard last
    ears: HearingState | None  # None: the robot has no microphones
    person: PersonState | None  # who the running command looks at
    goal: PointState | None
    path: list[tuple[float, float]]
    command: CommandState | None
    pending_command: PendingCommandState | None  # a spoken command that waits for its moment
    late_command: LateCommandState | None  # a spoken command that came too late, which a person may confirm
    camera: CameraOverlay | None
    calibration_drift: CalibrationDriftState | None
    robot: RobotState
    gate: GateState
    lease: LeaseState
    recording: RecorderState | None  # None: a recording plays
    playback: PlaybackView | None  # None: no recording of Beckon's own plays
    viewers: int  # people with a page or a program that listens, this one among them
    notices: list[NoticeLine]
    history_revision: int
    truth: TruePose | None
    by_laser: LaserReferenceState | None = None  # None: `[chapter] laser_reference` is off, or there is no laser
    route: RouteUnderWay | None = None  # None: none ran yet
    chapter: Literal["ours", "printed"] = "ours"  # the form that runs; printed: the chapter's own equations


class You(Struct):
    """The person a socket belongs to."""

    name: str
    role: Literal["viewer", "operator", "admin"]
    id: str


class RobotCard(Struct):
    """The description of the robot."""

    url: str
    kind: RobotKind
    name: str
    radius_m: float
    camera_view_rad: tuple[float, float] | None  # edges of the picture, right then left, left positive
    cruise_m_s: float
    max_speed_m_s: float
    max_turn_rate_rad_s: float
    drives: bool
    dry_run: bool  # nothing drives, a camera looks: commands to a person show what they would do
    capabilities: list[Capability]
    failsafe: str  # what the base does by itself when nobody speaks to it
    lock: str  # topic of the robot's own lock that STOP closes, too; "": none
    duration_s: float | None
    gaps_s: list[tuple[float, float]]  # of a recording, from its start: from and to where it has no scans


class HelloMessage(Struct, tag_field="kind", tag="hello"):
    """The first message of a socket."""

    you: You
    version: str
    robot: RobotCard
    console: str  # names this run of the console: another one knows nothing of what went before
    tab: str  # names this tab's 3-D scene: scene/ws/<tab>
    clock_ms: float  # of the console's steady clock now: the frames of a hand count on from it, over reloads
    chapter: Literal["ours", "printed"]  # printed: the chapter's own equations run in the place of our forms


class AnswerMessage(Struct, tag_field="kind", tag="answer", omit_defaults=True):
    """The result of a message that carried `ref`; 0 when it carried none."""

    ref: int
    ok: bool
    status: int
    detail: str | None = None
    suggestions: list[str] | None = None
    id: int | None = None
    code: str | None = None  # of the sentence in `detail`, which keeps its meaning in every language
    values: dict[str, str] | None = None  # in that sentence, by their names


class EchoBack(Struct, tag_field="kind", tag="echo"):
    """The same number back: measures the link."""

    t: float


Down = HelloMessage | State | CalibrationNews | AnswerMessage | EchoBack

encode = msgspec.json.Encoder(enc_hook=plain).encode
