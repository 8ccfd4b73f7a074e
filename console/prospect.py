"""What an order would do, told before it begins: a way, a goal, a bearing."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from core.commands import kind_of
from core.commands.command import Command
from core.commands.continue_straight import CONTINUE
from core.commands.stop_at import STOP_AT
from core.commands.turn import Turn
from core.geometry import Pose
from core.message import Array
from core.navigation.company import CompanySettings
from core.perception.people.call import Call
from core.snapshot import Snapshot

STEP = 0.1  # [rad] at most between two points of an arc
AROUND = 2.2  # radii of the robot from its middle at which a turn is drawn
TO_A_PERSON = ("come_here", "follow_me")
NOWHERE = np.zeros((0, 2))


@dataclass(frozen=True)
class Prospect:
    """In the world frame, as the robot stands now."""

    way: Array = field(default_factory=lambda: NOWHERE)  # (P, 2) [m]
    goal: tuple[float, float] | None = None  # [m]
    heading: float | None = None  # [rad] to which it turns
    call: Call | None = None  # to whom it goes


def foresee(command: Command, snapshot: Snapshot, radius: float) -> Prospect:
    """What the order would do; `radius` [m] of the robot. The way is straight: nothing is planned yet."""
    pose, kind = snapshot.estimate.pose, kind_of(command.name)
    if isinstance(kind, Turn):
        return _turned(pose, kind.side * command.numbers["angle_rad"], AROUND * radius)
    if command.name == CONTINUE.name:
        end = pose @ Pose(command.numbers["distance_m"], 0.0, 0.0)
        return _straight(pose, (end.x, end.y))
    if command.name == STOP_AT.name:
        return _straight(pose, (command.numbers["x_m"], command.numbers["y_m"]))
    return Prospect(call=_caller(command, snapshot)) if command.name in TO_A_PERSON else Prospect()


def _turned(pose: Pose, angle: float, radius: float) -> Prospect:
    angles = pose.heading + np.linspace(0.0, angle, max(2, math.ceil(abs(angle) / STEP) + 1))
    way = np.column_stack((pose.x + radius * np.cos(angles), pose.y + radius * np.sin(angles)))
    return Prospect(way=way, heading=math.remainder(pose.heading + angle, math.tau))


def _straight(pose: Pose, goal: tuple[float, float]) -> Prospect:
    return Prospect(way=np.array([(pose.x, pose.y), goal]), goal=goal)


def _caller(command: Command, snapshot: Snapshot) -> Call | None:
    """From where the words came; the voice heard last where nothing else is known of it."""
    voices = snapshot.hearing.voices if snapshot.hearing is not None else ()
    fresh = [voice.call for voice in voices if voice.age <= CompanySettings().fresh]
    return command.call or next(iter(fresh), None)
