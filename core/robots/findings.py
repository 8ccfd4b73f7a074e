"""Findings of a device behind its link, besides its equipment: topics with their roles, clocks, what is not known."""

from typing import Literal

import msgspec

from core.sensors.checks import Fault

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
