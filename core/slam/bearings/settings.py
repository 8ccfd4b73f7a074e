"""Settings of landmarks of which only bearings are measured."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

from core.setting import Meta, Section


@dataclass(frozen=True)
class BearingSettings(Section):
    """When a direction that is seen or heard again and again becomes a landmark. The defaults are those of edges."""

    used: Annotated[
        bool,
        Meta(meaning="whether they correct the pose; where the laser sees corners it is as good alone"),
    ] = False
    apart: Annotated[
        float, Meta("m", 0.01, 5, "way between two corrections, at least: from one place errors repeat")
    ] = 0.1
    apart_turn: Annotated[
        float, Meta("rad", 0.005, 3.2, "turn between two corrections, where the way is shorter")
    ] = math.radians(5)
    spacing: Annotated[float, Meta("m", 0.02, 5, "way between the poses that a new landmark is made from")] = 0.25
    poses: Annotated[int, Meta("", 3, 40, "such poses, at most")] = 8
    parallax: Annotated[
        float, Meta("rad", 0.005, 1.5, "difference of directions that makes a landmark, at least")
    ] = math.radians(4)
    vague: Annotated[float, Meta("", 0.01, 1, "sd of a new landmark's distance as a share of it, at most")] = 0.2
    nearest: Annotated[float, Meta("m", 0.05, 5, "distance of a new landmark, at least")] = 0.3
    farthest: Annotated[float, Meta("m", 1, 100, "distance of a new landmark, at most")] = 12.0
    floor: Annotated[float, Meta("rad", 0, 0.5, "sd of a bearing that adds to what the sensor claims")] = 0.0
    gate: Annotated[
        float, Meta("χ²", 1, 100, "squared distance of a bearing that is used, at most; 99.7 % at 1 dof")
    ] = 9.0
    follow: Annotated[float, Meta("rad", 1e-3, 1, "change of a direction between two looks, at most")] = math.radians(
        0.8
    )
    follow_per_way: Annotated[float, Meta("rad/m", 0, 20, "further change per way driven between them")] = 0.7
    lapse: Annotated[
        float, Meta("s", 0.05, 60, "time after which a direction that is not seen again is given up")
    ] = 0.5
    chances: Annotated[int, Meta("", 1, 50, "corrections in a row that a landmark contradicts before it goes")] = 3
    again: Annotated[
        float, Meta("m", 0, 5, "sd of the distance of two landmarks that may be one, at most; 0: never")
    ] = 0.3
    most: Annotated[int, Meta("", 1, 500, "landmarks of a submap, at most; those seen last stay")] = 60
    walls: Annotated[
        bool, Meta(meaning="whether a landmark on a wall that the laser sees takes its distance from it")
    ] = True
    wall_sd: Annotated[float, Meta("m", 0.002, 1, "sd of such a distance across the wall")] = 0.02


@dataclass(frozen=True)
class VoiceLandmarkSettings(BearingSettings):
    """The same for a person who stands and calls."""

    apart: Annotated[
        float, Meta("m", 0.01, 5, "way between two corrections, at least: from one place errors repeat")
    ] = 0.2
    apart_turn: Annotated[
        float, Meta("rad", 0.005, 3.2, "turn between two corrections, where the way is shorter")
    ] = 3.2
    spacing: Annotated[float, Meta("m", 0.02, 5, "way between the poses that a new landmark is made from")] = 0.3
    parallax: Annotated[
        float, Meta("rad", 0.005, 1.5, "difference of directions that makes a landmark, at least")
    ] = math.radians(25)
    floor: Annotated[float, Meta("rad", 0, 0.5, "sd of a bearing that adds to what the sensor claims")] = (
        math.radians(3)
    )
    follow: Annotated[float, Meta("rad", 1e-3, 1, "change of a direction between two looks, at most")] = math.radians(
        15
    )
    follow_per_way: Annotated[float, Meta("rad/m", 0, 20, "further change per way driven between them")] = 1.0
    lapse: Annotated[
        float, Meta("s", 0.05, 60, "time after which a direction that is not seen again is given up")
    ] = 10.0
    chances: Annotated[int, Meta("", 1, 50, "corrections in a row that a landmark contradicts before it goes")] = 4
    again: Annotated[
        float, Meta("m", 0, 5, "sd of the distance of two landmarks that may be one, at most; 0: never")
    ] = 0.6
    most: Annotated[int, Meta("", 1, 500, "landmarks of a submap, at most; those seen last stay")] = 4
    walls: Annotated[
        bool, Meta(meaning="whether a landmark on a wall that the laser sees takes its distance from it")
    ] = False
