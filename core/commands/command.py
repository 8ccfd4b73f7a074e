"""Commands, and the actions that carry them out."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, Protocol

import numpy as np

from core.gate import Twist
from core.geometry import Pose
from core.message import Array, message
from core.navigation.control_context import ControlContext
from core.perception.people.tracked_person import TrackedPerson
from core.perception.people.voice_bearing import VoiceBearing

Target = Literal["none", "place", "person"]
MIN_CONFIRMED_DISTANCE_M = 2.0  # from which a distance is confirmed
ARC_STEP_RAD = 0.1  # at most between two points of an arc
NOWHERE = np.zeros((0, 2))


@message
class Parameter:
    """A parameter of a command."""

    name: str  # "distance_m": its key in JSON, with the unit
    says: str  # "x": how Table 2 writes it
    unit: str  # "m" | "rad"
    low: float
    high: float
    default: float | None = None  # None: the words must give it
    spoken_high: float | None = None  # a tighter bound on the size of what was spoken aloud; None: none


@message
class Command:
    """Words that were understood."""

    name: str  # "continue"
    numbers: Mapping[str, float]  # {"distance_m": 1.5}
    heard_as: str  # canonical words: "continue 1.5 meters"
    remark: str = ""  # a sentence for the operator: why this and not what the words began to say
    call: VoiceBearing | None = None  # from where it was spoken; None: it was not spoken, or the direction is unknown
    said: tuple[float, float] | None = None  # [s] robot's clock: from when to when its words were heard
    others: tuple[VoiceBearing, ...] = ()  # from where else a voice was heard meanwhile: an echo, another talker
    place: str = ""  # the name of the place that it goes to; its numbers are where that is


@message
class Progress:
    """One step of obeying."""

    twist: Twist = Twist()
    finished: str = ""  # "" while under way, else "done" or "failed"
    remark: str = ""  # a sentence for the operator
    fraction: float | None = None  # 0..1 of the way
    path: Array | None = None  # (P, 2) [m], world: newly planned; None: unchanged
    goal: Array | None = None  # (2,) [m], world
    person: TrackedPerson | None = None  # who is looked at


class Action(Protocol):
    """A command under way: made once by the kind's `begin`, then asked for a twist with every frame."""

    def drive(self, ctx: ControlContext) -> Progress:
        """Take one frame."""
        ...


@dataclass(frozen=True)
class CommandPreview:
    """The effect of a command in the world frame, as the robot stands now; the path is not planned yet."""

    path: Array = field(default_factory=lambda: NOWHERE)  # (P, 2) [m]
    goal: tuple[float, float] | None = None  # [m]
    heading: float | None = None  # [rad] to which it turns

    @classmethod
    def turn(cls, pose: Pose, angle: float, radius: float) -> CommandPreview:
        """A turn by `angle` [rad] on the spot, drawn as an arc of `radius` [m]."""
        angles = pose.heading + np.linspace(0.0, angle, max(2, math.ceil(abs(angle) / ARC_STEP_RAD) + 1))
        path = np.column_stack((pose.x + radius * np.cos(angles), pose.y + radius * np.sin(angles)))
        return cls(path=path, heading=math.remainder(pose.heading + angle, math.tau))

    @classmethod
    def straight(cls, pose: Pose, goal: tuple[float, float]) -> CommandPreview:
        """A straight line to `goal` [m]."""
        return cls(path=np.array([(pose.x, pose.y), goal]), goal=goal)


@dataclass(frozen=True, kw_only=True)
class CommandSpec(ABC):
    """One row of Table 2; its own file says what differs from these defaults."""

    name: str  # the row's key in JSON: "turn_left"
    words: tuple[str, ...]  # patterns, the first is the canonical one; numbers as in "continue {distance_m} meters"
    example: str  # words that are understood as they stand: "continue 1.5 meters"
    summary: str  # a sentence for people: "Turns left 90 degrees on the spot."
    numbers: tuple[Parameter, ...] = ()
    moves: bool = True  # the robot
    target: Target = "none"  # where it goes
    endless: bool = False  # goes on until another command, and gives way to any
    needs_pose: bool = True  # is not obeyed while the robot does not know where it is
    already: str = ""  # said when it is given again while it is under way; "": a common sentence
    icon: str = ""  # its drawing in static/img/icons.svg; "": a common one
    pronunciations: Mapping[str, str] = field(default_factory=dict[str, str])  # of its words, which dictionaries lack
    fixed: Mapping[str, str] = field(default_factory=dict[str, str])  # said in JSON beside its numbers

    @property
    def idempotent(self) -> bool:
        """True where the same command again, while it is active, asks for nothing new."""
        return self.endless or self.target != "none"

    def needs_confirmation(self, numbers: Mapping[str, float]) -> bool:
        """Return whether it waits for the confirmation delay, however surely it was heard: it goes far."""
        return self.target != "none" or abs(numbers.get("distance_m", 0.0)) > MIN_CONFIRMED_DISTANCE_M

    def preview(self, numbers: Mapping[str, float], pose: Pose, radius: float) -> CommandPreview:
        """Return what it would do from `pose`; `radius` [m] at which a turn is drawn."""
        return CommandPreview()

    @abstractmethod
    def begin(self, command: Command, ctx: ControlContext) -> Action:
        """Start the command. Raises Refused with a sentence when that is impossible from here."""
