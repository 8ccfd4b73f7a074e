"""A device of a real robot: its base, a laser, a camera, microphones, or all of them behind one link.

To write one: subclass Device, open the link in `open` and say what is there, hand on what comes in `run`, set the
wheels in `drive`, let go in `close`. Everything else (a thread, connecting again, silence, clocks) is LiveRobot's.
Besides its equipment it has findings: topics with their roles, clocks, what is not known.
"""

from abc import ABC, abstractmethod
from typing import Literal

import msgspec

from core.errors import BadInput
from core.gate.twist import Twist
from core.message import message
from core.robots.readings import Readings
from core.robots.requests import AnswerT, Requests, RobotRequest
from core.robots.urdf import Body
from core.sensors import Camera, Laser
from core.sensors.checks import Fault
from core.sensors.microphones import MicrophoneArray

Role = Literal[
    "odometry", "scan", "image", "camera_info", "sound", "cmd_vel", "battery", "map", "pose", "frames", "description"
]


class CandidateTopic(msgspec.Struct, frozen=True, kw_only=True):
    """A topic that could have a role."""

    topic: str
    type: str  # "sensor_msgs/msg/LaserScan"; "": the robot does not say it


class UsedTopic(CandidateTopic, frozen=True, kw_only=True):
    """A topic that has a role, and what comes on it."""

    frame: str = ""  # of its newest message; "": none came, or it has none
    rate_hz: float | None = None  # None: too few messages came
    age_s: float | None = None  # since the newest message; None: none came
    guessed: bool = False  # its type: the robot does not say which it takes


class TopicRole(msgspec.Struct, frozen=True, kw_only=True):
    """A role and the topics that have it now; `candidates` are all that could, these among them."""

    role: Role
    used: tuple[UsedTopic, ...] = ()
    candidates: tuple[CandidateTopic, ...] = ()
    most: int = 1  # topics that may have it
    remark: str = ""  # a sentence about what is missing


class ClockOffset(msgspec.Struct, frozen=True, kw_only=True):
    """A clock whose stamps are put on the robot's."""

    clock: str  # whose: "/scan, /odom", "laser"
    offset_s: float  # the robot's clock, which begins with the connection, minus this one
    ahead_s: float | None = None  # this one minus the console's time of day; None: it tells no time of day


class Findings(msgspec.Struct, frozen=True, kw_only=True):
    """Findings of one device."""

    base_frame: str = ""
    roles: tuple[TopicRole, ...] = ()  # () for a device without topics
    placed: tuple[str, ...] = ()  # the device's own names of the sensors whose mounting it knows
    clocks: tuple[ClockOffset, ...] = ()
    faults: tuple[Fault, ...] = ()  # what the checks of its readings found
    remarks: tuple[str, ...] = ()  # sentences: ambiguities, and what is missing


@message
class Base:
    """The base, which drives the robot."""

    radius: float | None = None  # [m] of the round footprint; None: not known
    wheelbase: float | None = None  # [m]
    cruise: float | None = None  # [m/s]
    max_speed: float | None = None  # [m/s]
    max_turn_rate: float | None = None  # [rad/s]
    failsafe: float | None = None  # [s] without a word after which the base stops by itself; None: it never does
    failsafe_words: str = ""  # a sentence, where that needs more words: "It stops … but any byte counts as one."
    odometry: bool = True  # it says how far it has rolled
    lock: str = ""  # topic of the lock of its own that is closed while it is to stand


@message
class Equipment:
    """The parts of a device; LiveRobot makes the robot's profile of it."""

    name: str
    base: Base | None = None
    lasers: tuple[Laser, ...] = ()
    cameras: tuple[Camera, ...] = ()
    microphones: tuple[MicrophoneArray, ...] = ()
    body: Body | None = None  # as the robot itself describes it
    navigates: bool = False  # it has a navigation of its own, and takes the requests for it


class Device(ABC):
    """Base class of all. `open` and `run` are called from the device's own thread, `drive` from the driver's."""

    def __init__(self, arguments: str = "") -> None:
        """`arguments`: what follows the scheme, or the file, in the robot's URL. Raises BadInput."""

    @abstractmethod
    def open(self) -> Equipment:
        """Connect, within a few seconds → what is there.

        Raises Unavailable with a sentence (or OSError) while the other side cannot be reached, BadInput when it never
        will.
        """

    @abstractmethod
    def run(self, readings: Readings) -> None:
        """Hand on what comes until the link is lost or `close` is called, then return or raise OSError.

        It is opened again after either, and what was set by `drive` before is forgotten.
        """

    def drive(self, twist: Twist) -> None:
        """Set speeds, which hold until the next call; called 40 times a second. Must not wait.

        Never called while the link is down. Only the base needs it.
        """

    def findings(self) -> Findings:
        """Return the findings besides the equipment; asked from the driver's thread now and then, must not wait."""
        return Findings()

    @property
    def requests(self) -> Requests:
        """The requests that it takes, known when it is open; none as a rule."""
        return ()

    def ask(self, request: RobotRequest[AnswerT]) -> AnswerT:
        """One of `requests` → its answer, at once. Raises BadInput, Refused or Unavailable with a sentence."""
        raise BadInput("This device takes no such request.")

    def close(self) -> None:
        """Let go of the link, from any thread, so that `run` returns; harmless when done twice."""
