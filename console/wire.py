"""What goes over the sockets, typed once: `python -m console.wire` writes the same types for the browser.

Keys carry their unit. What is not a finite number leaves as null.
"""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Literal

import msgspec

from console.wire_calibration import CalibrationAdvice as CalibrationAdvice
from console.wire_calibration import CalibrationBars as CalibrationBars
from console.wire_calibration import CalibrationBoard as CalibrationBoard
from console.wire_calibration import CalibrationCheck as CalibrationCheck
from console.wire_calibration import CalibrationNews as CalibrationNews
from console.wire_calibration import CalibrationProgress as CalibrationProgress
from console.wire_calibration import CalibrationScan as CalibrationScan
from console.wire_calibration import CalibrationSession as CalibrationSession
from console.wire_calibration import CalibrationSolving as CalibrationSolving
from console.wire_calibration import CalibrationUncertainty as CalibrationUncertainty
from console.wire_calibration import CalibrationVerdict as CalibrationVerdict
from console.wire_calibration import CalibrationView as CalibrationView
from console.wire_floor import Candidate as Candidate
from console.wire_floor import ClosureRow as ClosureRow
from console.wire_floor import FloorState as FloorState
from console.wire_floor import LostState as LostState
from console.wire_floor import MapState as MapState
from console.wire_floor import Spot as Spot
from console.wire_floor import SubmapRow as SubmapRow
from console.wire_hearing import Ears as Ears
from console.wire_hearing import VoiceHeard as VoiceHeard
from console.wire_intent import IntentState as IntentState
from console.wire_intent import Order as Order
from console.wire_people import BodyPart as BodyPart
from console.wire_people import PersonState as PersonState
from console.wire_people import SensedBearing as SensedBearing
from console.wire_sight import CalibrationDrift as CalibrationDrift
from console.wire_sight import PictureQuality as PictureQuality
from console.wire_up import Count as Count
from console.wire_up import Drive as Drive
from console.wire_up import Echo as Echo
from console.wire_up import Halt as Halt
from console.wire_up import HaltReset as HaltReset
from console.wire_up import Inward as Inward
from console.wire_up import LeaseWish as LeaseWish
from console.wire_up import Playback as Playback
from console.wire_up import Say as Say
from console.wire_up import Short as Short
from console.wire_up import Source as Source
from console.wire_up import Stop as Stop
from console.wire_up import Up as Up
from console.wire_up import Want as Want
from core.robots import Kind
from core.snapshot import Ending, Level

Struct = msgspec.Struct

CAMERA_HEADER = struct.Struct("<BxxxId")  # kind = 1, sequence number, stamp [s]; the JPEG follows


class Place(Struct):
    """A point of the world frame."""

    x_m: float
    y_m: float


class Pose(Struct):
    """A pose of the world frame and its covariance."""

    x_m: float
    y_m: float
    heading_rad: float
    cov: list[list[float]]  # 3x3 of x, y, heading


class TruePose(Struct):
    """Where the simulated robot really is."""

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


class Slam(Struct):
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


class CommandState(Order):
    """A command and how it goes."""

    state: Ending
    remark: str
    progress: float | None


class EdgeLine(Struct):
    """A vertical edge in the newest picture, in pixels."""

    u0: float
    v0: float
    u1: float
    v1: float
    bearing_rad: float
    matched: bool


class CameraOverlay(Struct):
    """What perception drew on the newest picture."""

    stamp_s: float
    width: int
    height: int
    edges: list[EdgeLine]
    laser: list[tuple[float, float, float]]  # u, v [pixel], range [m]
    quality: PictureQuality | None


class RobotState(Struct):
    """The robot and the link to it."""

    url: str
    kind: Kind
    name: str
    link: Literal["connecting", "live", "stale", "lost"]
    age_s: float | None
    rate_hz: float
    contact: bool
    running: bool
    progress: float | None
    speed: float


class GateState(Struct):
    """What the gate lets through."""

    state: str  # disarmed | armed | halted
    reason: str
    v_m_s: float
    w_rad_s: float
    source: str
    nonce: int
    epoch: int
    limit_v_m_s: float | None
    blocked_by: Place | None
    need_neutral: bool


class LeaseState(Struct):
    """Who drives."""

    holder: str | None
    holder_id: str | None
    epoch: int


class NoticeLine(Struct):
    """A sentence for the operator."""

    id: int
    stamp_s: float
    level: Level
    text: str


class State(Struct, tag_field="kind", tag="state"):
    """Everything that may be shown at one instant; the newest replaces the older."""

    seq: int
    stamp_s: float
    pose: Pose
    dead_reckoning: Pose
    velocity: Velocity
    landmarks: list[LandmarkRow]
    slam: Slam
    floor: FloorState
    map: MapState
    direction: VoiceHeard | None  # the voice that was heard last
    ears: Ears | None  # None: the robot has no microphones
    person: PersonState | None  # who the running command looks at
    goal: Place | None
    path: list[tuple[float, float]]
    command: CommandState | None
    intent: IntentState | None  # a spoken order that waits for its moment
    camera: CameraOverlay | None
    calibration_drift: CalibrationDrift | None
    robot: RobotState
    gate: GateState
    lease: LeaseState
    viewers: int
    notices: list[NoticeLine]
    history_revision: int
    truth: TruePose | None


class You(Struct):
    """The person a socket belongs to."""

    name: str
    role: Literal["viewer", "operator", "admin"]
    id: str


class RobotCard(Struct):
    """What the robot is."""

    url: str
    kind: Kind
    name: str
    radius_m: float
    cruise_m_s: float
    max_speed_m_s: float
    max_turn_rate_rad_s: float
    drives: bool
    duration_s: float | None


class Hello(Struct, tag_field="kind", tag="hello"):
    """The first message of a socket."""

    you: You
    version: str
    robot: RobotCard
    tab: str  # names this tab's 3-D scene: scene/ws/<tab>
    clock_ms: float  # of the console's steady clock now: the frames of a hand count on from it, over reloads


class Answer(Struct, tag_field="kind", tag="answer", omit_defaults=True):
    """What became of a message that carried `ref`; 0 when it carried none."""

    ref: int
    ok: bool
    status: int
    detail: str | None = None
    suggestions: list[str] | None = None
    id: int | None = None


class EchoBack(Struct, tag_field="kind", tag="echo"):
    """The same number back: measures the link."""

    t: float


Down = Hello | State | CalibrationNews | Answer | EchoBack

encode = msgspec.json.Encoder().encode


if __name__ == "__main__":
    from console.wire_js import generate_wire_js

    for name, text in generate_wire_js().items():
        Path(__file__).parent.parent.joinpath("static/js", name).write_text(text)
