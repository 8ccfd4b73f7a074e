"""The record of one frame in Beckon's own recordings: what its ROS messages do not hold to the last bit.

Stamps of ROS are whole nanoseconds and angles of a scan float32; here stand the numbers themselves, in JSON, beside
what the pilot took with the frame and what it made of it. The readings' bulk (ranges, pictures, samples) lies in the
messages of the same moment.
"""

import math
from typing import Self

import msgspec

from core.geometry import Pose
from core.message import Array
from core.sensors import Fault, Image, Scan, SensorFrame, Sound, Wheels
from core.sentences import plain
from core.slam.map.edits import CellEdit

FRAME, ROBOT = "/beckon/frame", "/beckon/robot"  # topics: one of every frame; the robot as built and as used
WHOLE_MAP = "/beckon/map"  # topic: the map that an estimator can go on in, now and then

Struct = msgspec.Struct
Row = tuple[float, float, float]  # x, y [m], heading [rad]


class WheelsRecord(Struct, frozen=True, array_like=True):
    """A reading of the wheels."""

    place: Row
    speed: float
    turn_rate: float
    age: float
    rate: float | None


class ScanRecord(Struct, frozen=True, array_like=True):
    """All of a scan but its ranges."""

    stamp: float
    laser: str
    angle_min: float
    angle_step: float
    range_min: float
    range_max: float | None  # None: no bound
    time_step: float


class PlaceAct(Struct, frozen=True, tag="place"):
    """The operator said where the robot is."""

    x: float
    y: float
    heading: float | None


class ClosureAct(Struct, frozen=True, tag="closure"):
    """The operator took a recognised place back, or believed it again."""

    number: int
    believed: bool


class MapAct(Struct, frozen=True, tag="map"):
    """The operator loaded a map."""

    content: bytes  # of the map's file


class EditAct(Struct, frozen=True, tag="edit"):
    """The operator edited the map: all edits that hold from here on."""

    edits: tuple[tuple[CellEdit, float, tuple[tuple[float, float], ...]], ...]  # kind, width [m], points [m], world


class TurnAct(Struct, frozen=True, tag="turn"):
    """The operator turned the map about the origin of the world."""

    angle: float  # [rad]


class UsedAct(Struct, frozen=True, tag="used"):
    """The robot is seen otherwise from here on: it was calibrated."""

    profile: bytes  # JSON


TakenAct = PlaceAct | ClosureAct | MapAct | EditAct | TurnAct | UsedAct
"""An act of people between two frames that changes the estimate."""


class TakenRecord(Struct, frozen=True, omit_defaults=True):
    """All that the pilot took beside the readings."""

    first: bool = False  # a pilot began with this frame
    deaf: bool = False  # the sound was not listened to: the robot spoke
    doing: str = ""  # name of the command that was under way
    acts: tuple[TakenAct, ...] = ()


class ResultRecord(Struct, frozen=True, omit_defaults=True):
    """All that the console made of the frame; rows that have not changed are None."""

    pose: Row
    covariance: tuple[float, ...]  # (3, 3), row by row
    dead_reckoning: Row
    velocity: tuple[float, float] = (0.0, 0.0)  # [m/s], [rad/s]
    gate: str = ""  # state
    operator: str = ""
    command: dict[str, object] | None = None  # that runs
    endings: tuple[dict[str, object], ...] = ()
    voices: tuple[dict[str, object], ...] = ()
    edges: tuple[tuple[float, ...], ...] | None = None  # u, v of top and bottom, bearing, matched, step
    landmarks: tuple[tuple[float | str, ...], ...] | None = None  # id, x, y, xx, xy, yx, yy, hits, misses, kind
    map_digest: str = ""  # of the grid that was sent with this frame, to the last bit
    goal: tuple[float, ...] | None = None
    path: tuple[tuple[float, ...], ...] = ()
    lost: str = ""  # a sentence while the robot does not know where it is


class RobotRecord(Struct, frozen=True):
    """The robot's profile as built, and as calibrated when the recording began; see `core.robots.profile_json`."""

    built: msgspec.Raw
    used: msgspec.Raw


class FrameRecord(Struct, frozen=True, kw_only=True, omit_defaults=True):
    """One frame."""

    stamp: float
    wheels: WheelsRecord | None = None
    scan: ScanRecord | None = None
    image: tuple[float, str] | None = None  # stamp, camera
    sound: tuple[float, int] | None = None  # stamp, rate
    contact: bool = False
    battery: float | None = None
    truth: Row | None = None
    trouble: str = ""
    faults: tuple[Fault, ...] = ()
    notes: tuple[str, ...] = ()
    pace: float = 1.0
    taken: TakenRecord | None = None  # None: no pilot, `beckon record`
    results: ResultRecord | None = None

    @classmethod
    def of(cls, frame: SensorFrame, taken: TakenRecord | None = None, results: ResultRecord | None = None) -> Self:
        """A frame without the bulk of its readings."""
        wheels, scan, image, sound = frame.wheels, frame.scan, frame.image, frame.sound
        return cls(
            stamp=frame.stamp,
            wheels=None
            if wheels is None
            else WheelsRecord(row_of(wheels.odometry), wheels.speed, wheels.turn_rate, wheels.age, wheels.rate),
            scan=None if scan is None else _scan(scan),
            image=None if image is None else (image.stamp, image.camera),
            sound=None if sound is None else (sound.stamp, sound.rate),
            contact=frame.contact,
            battery=frame.battery,
            truth=None if frame.truth is None else row_of(frame.truth),
            trouble=frame.trouble,
            faults=frame.faults,
            notes=frame.notes,
            pace=frame.pace,
            taken=taken,
            results=results,
        )

    def frame(self, ranges: Array | None, picture: Image | None, samples: Array | None) -> SensorFrame:
        """The frame again; a reading whose bulk is missing is left out."""
        scan, wheels = self.scan, self.wheels
        return SensorFrame(
            stamp=self.stamp,
            wheels=None if wheels is None else _wheels_again(wheels),
            scan=None if scan is None or ranges is None else _scan_again(scan, ranges),
            image=picture,
            sound=None
            if self.sound is None or samples is None
            else Sound(stamp=self.sound[0], rate=self.sound[1], samples=samples),
            contact=self.contact,
            battery=self.battery,
            truth=None if self.truth is None else Pose(*self.truth),
            trouble=self.trouble,
            faults=self.faults,
            notes=self.notes,
            pace=self.pace,
        )


encode = msgspec.json.Encoder(enc_hook=plain).encode
decode = msgspec.json.Decoder(FrameRecord).decode


def row_of(pose: Pose) -> Row:
    """A pose as it is written."""
    return pose.x, pose.y, pose.heading


def _wheels_again(record: WheelsRecord) -> Wheels:
    return Wheels(
        odometry=Pose(*record.place), speed=record.speed, turn_rate=record.turn_rate, age=record.age, rate=record.rate
    )


def _scan(scan: Scan) -> ScanRecord:
    farthest = scan.range_max if math.isfinite(scan.range_max) else None
    return ScanRecord(
        scan.stamp, scan.laser, scan.angle_min, scan.angle_step, scan.range_min, farthest, scan.time_step
    )


def _scan_again(record: ScanRecord, ranges: Array) -> Scan:
    return Scan(
        stamp=record.stamp,
        laser=record.laser,
        ranges=ranges,
        angle_min=record.angle_min,
        angle_step=record.angle_step,
        range_min=record.range_min,
        range_max=math.inf if record.range_max is None else record.range_max,
        time_step=record.time_step,
    )
