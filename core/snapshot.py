"""Everything that may be shown at one instant, and nothing else may."""

from collections.abc import Iterable
from typing import Literal

from core.calibration.laser.drift import Drift
from core.gate import Twist
from core.geometry import Pose
from core.message import Array, message
from core.perception.image_quality.quality import PictureQuality
from core.perception.landmarks.edges import ImageEdge
from core.perception.people.tracked_person import TrackedPerson
from core.perception.people.voice_bearing import VoiceBearing
from core.recording.frame_record import ClosureAct, EditAct, PlaceAct, TurnAct
from core.robots import Profile
from core.sensors import SensorFrame
from core.slam.estimate import Association, Estimate, Landmark, SlamHealth
from core.slam.map.map_file import SavedMap
from core.slam.map.occupancy import OccupancyGrid
from core.slam.map.status import MapStatus
from core.slam.motion import Increment
from core.slam.scan_matching.agreement import MoveAgreement
from core.slam.scan_matching.time_offset import TimeOffset

VOICE_BEFORE, VOICE_AFTER = 0.2, 1.5  # [s] by which a direction may be older than words, and younger

Level = Literal["info", "warning", "error"]
Ending = Literal["running", "done", "refused", "cancelled", "pre-empted", "failed"]


@message
class Notice:
    """A sentence for the operator."""

    id: int
    stamp: float  # [s]
    level: Level
    text: str
    cause: str = ""  # what it is about, where it can change and end; the newest replaces the older of one cause
    at: float = 0.0  # Unix time [s] at which the console took it


SensorKind = Literal["wheels", "laser", "camera", "microphones"]
SensorState = Literal["live", "stale", "lost"]


@message
class SensorStatus:
    """A sensor that the robot has, and whether it delivers."""

    kind: SensorKind
    name: str
    state: SensorState
    age: float  # [s] since its newest reading
    rate: float  # [Hz] at which it should deliver


@message
class ActiveCommandStatus:
    """A command and how it goes."""

    id: int
    name: str  # "turn_left"
    numbers: dict[str, float]  # {"distance_m": 1.5}
    heard_as: str  # the words that were understood
    source: str  # "typed" | "chip" | "click" | "camera" | "rest" | …
    who: str
    stamp: float  # [s] when it was accepted, robot clock
    state: Ending = "running"
    remark: str = ""  # a sentence: why it ended so, or what it is waiting for
    progress: float | None = None  # 0..1


@message
class CameraView:
    """The drawings of perception on the newest picture; the picture itself is sent separately."""

    stamp: float
    width: int
    height: int
    edges: tuple[ImageEdge, ...] = ()
    laser: Array  # (M, 3): u, v [pixel] and range [m] of the laser points in view
    quality: PictureQuality | None = None


@message
class VoiceDirection:
    """The direction of a voice, as heard from the robot."""

    id: int
    stamp: float  # [s] when it was last heard
    age: float  # [s] since then
    azimuth: float  # [rad] in the robot's frame, as the robot stands now
    azimuth_world: float  # [rad]
    sd: float  # [rad] of the azimuth now: who spoke may have walked on since
    sd_heard: float  # [rad] of the azimuth when it was last heard, with the doubt of the robot's own heading
    elevation: float | None  # [rad] above the microphones; None: not known
    ambiguity: str = ""  # what a flat array cannot know, in words
    strength: float  # 0..1, how much of the sound came from there
    heard_at: Array  # (2,) [m] world: where the robot was when it was last heard

    @property
    def call(self) -> VoiceBearing:
        """As a command takes it."""
        x, y = self.heard_at.tolist()
        return VoiceBearing(
            stamp=self.stamp, azimuth=self.azimuth_world, sd=self.sd_heard, x=x, y=y, strength=self.strength
        )


def voice_between(voices: Iterable[VoiceDirection], begin: float, end: float) -> VoiceDirection | None:
    """Return the strongest voice that was heard while words were spoken, from `begin` to `end` [s]."""
    near = [one for one in voices if begin - VOICE_BEFORE <= one.stamp <= end + VOICE_AFTER]
    return max(near, key=lambda one: one.strength, default=None)


@message
class Hearing:
    """The sound of the microphones: its level and the voices in it."""

    listening: bool  # sound comes in
    speaking: bool  # an utterance is under way
    level_db: float | None  # [dB of full scale]; None: no sound comes
    voices: tuple[VoiceDirection, ...] = ()  # most recently heard first


PilotAct = PlaceAct | ClosureAct | EditAct | TurnAct | SavedMap | Profile
"""An act between two frames that changes estimate or map: a place, a closure, edits, a loaded map, a calibration."""


@message
class PilotInputs:
    """All that the pilot took with one frame: the same again gives the same estimate, to the last bit."""

    frame: SensorFrame  # as it came
    deaf: bool = False  # its sound was not listened to: the robot itself spoke
    doing: str = ""  # name of the command that was under way when it came
    acts: tuple[PilotAct, ...] = ()  # since the frame before
    first: bool = False  # the pilot began with it


@message
class Comparison:
    """The other way of a recording that is shown: what is computed now beside what was recorded, or the reverse.

    Poses lie in the world of the way that is shown.
    """

    pose: Pose
    trail: Array  # (K, 2) [m]
    landmarks: Array  # (N, 2) [m]
    distance: float  # [m] between the two poses
    turn: float  # [rad]: other minus shown
    worst: float  # [m]: the largest distance since what is computed began
    landmark_counts: tuple[int, int]  # recorded, computed
    edge_counts: tuple[int, int]  # of the newest picture
    direction: float | None  # [rad] between the voices that were heard last; None: one has none
    frames: int  # that were compared
    same: bool  # every pose, edge, direction and map until now, to the last bit


@message
class Snapshot:
    """The state of everything after one frame. Only the pilot makes one."""

    stamp: float  # [s], robot clock
    estimate: Estimate
    dead_reckoning: Estimate
    by_laser: Estimate | None = None  # by laser and wheels alone; None: it is not asked for
    increment: Increment  # the robot's move since the frame before
    velocity: Twist  # as the wheels report it
    setpoint: Twist  # what the pilot asks of the gate
    setpoint_command_id: int = 0  # id of the active command that asks; 0: none
    nonce: int = 0  # the gate's nonce that came with the frame
    scan_points: Array  # (M, 2) [m], world: the newest scan, de-skewed
    landmarks: tuple[Landmark, ...] = ()
    associations: tuple[Association, ...] = ()
    slam: SlamHealth
    floor: MapStatus = MapStatus()
    grid: OccupancyGrid
    trail: Array  # (K, 2) [m], world: the path so far, thinned
    dead_reckoning_trail: Array  # (K, 2) [m]
    path: Array  # (P, 2) [m], world: what is planned; empty without a plan
    goal: Array | None = None  # (2,) or (3,) [m], world
    active_command: ActiveCommandStatus | None = None  # the one that runs
    endings: tuple[ActiveCommandStatus, ...] = ()  # those that ended with this frame
    view: CameraView | None = None
    hearing: Hearing | None = None  # None: the robot has no microphones
    person: TrackedPerson | None = None  # who is looked at by the command that runs
    drift: Drift | None = None  # how the camera's mount seems to differ from its calibration
    timings: tuple[TimeOffset, ...] = ()  # of the lasers whose time offset is known
    agreement: MoveAgreement | None = None  # of wheels and scans
    notices: tuple[Notice, ...] = ()  # newest last, at most 20
    sensors: tuple[SensorStatus, ...] = ()
    contact: bool = False
    pace: float = 1.0  # share of real time at which the robot's clock runs
    battery: float | None = None  # 0..1
    running: bool = True
    progress: float | None = None
    truth: Pose | None = None  # simulator only, passed through for scoring; never read by an estimator
    inputs: PilotInputs | None = None  # that it was made of
    other: Comparison | None = None  # the other way of a recording, where both are shown
