"""Settings of landmarks of which only bearings are measured."""

import math
from dataclasses import dataclass
from typing import Annotated

from core.setting import Meta, Section, ThresholdSet


@dataclass(frozen=True)
class BearingThresholds(ThresholdSet):
    """When directions become a landmark and correct the pose; the defaults are those of edges."""

    apart: float = 0.1  # [m] way between two corrections, at least: from one place errors repeat
    apart_turn: float = math.radians(5)  # [rad] turn between two corrections, where the way is shorter
    spacing: float = 0.25  # [m] way between the poses that a new landmark is made from
    poses: int = 8  # such poses, at most
    parallax: float = math.radians(4)  # [rad] difference of directions that makes a landmark, at least
    vague: float = 0.2  # sd of a new landmark's distance as a share of it, at most
    nearest: float = 0.3  # [m] distance of a new landmark, at least
    floor: float = 0.0  # [rad] sd of a bearing that adds to what the sensor claims
    gate: float = 9.0  # [χ²] squared distance of a bearing that is used, at most; 99.7 % at 1 dof
    follow: float = math.radians(0.8)  # [rad] change of a direction between two looks, at most
    follow_per_way: float = 0.7  # [rad/m] further change per way driven between them
    lapse: float = 0.5  # [s] time after which a direction that is not seen again is given up
    chances: int = 3  # corrections in a row that a landmark contradicts before it goes
    again: float = 0.3  # [m] sd of the distance of two landmarks that may be one, at most; 0: never
    most: int = 60  # landmarks of a submap, at most; those seen last stay
    walls: bool = True  # whether a landmark on a wall that the laser sees takes its distance from it
    wall_sd: float = 0.02  # [m] sd of such a distance across the wall


@dataclass(frozen=True)
class BearingSettings(BearingThresholds, Section):
    """When a direction that is seen or heard again and again becomes a landmark. The defaults are those of edges.

    Watch:
        used: the pose's sd in a corridor
        farthest: landmarks far outside the room (then lower it)
    """

    used: Annotated[
        bool, Meta(meaning="whether they correct the pose; where the laser sees corners it is as good alone")
    ] = False
    farthest: Annotated[float, Meta("m", 1, 100, "distance of a new landmark, at most")] = 12.0


@dataclass(frozen=True)
class VoiceLandmarkSettings(BearingSettings):
    """The same for a person who stands and calls."""

    apart: float = 0.2
    apart_turn: float = 3.2
    spacing: float = 0.3
    parallax: float = math.radians(25)
    floor: float = math.radians(3)
    follow: float = math.radians(15)
    follow_per_way: float = 1.0
    lapse: float = 10.0
    chances: int = 4
    again: float = 0.6
    most: int = 4
    walls: bool = False
