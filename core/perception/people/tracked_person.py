"""The person who is followed, as known at one instant, and the numbers that following takes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Literal

from core.message import Array, message
from core.perception.people.detector import Rectangle
from core.perception.people.fusion import Ray, Sense
from core.setting import Meta, Section


@dataclass(frozen=True)
class TrackSettings(Section):
    """Birth, gate and death of the one who is followed."""

    births: Annotated[int, Meta("", 1, 20, "pictures with the person in them until the person is confirmed")] = 2
    acceleration: Annotated[float, Meta("m/s²", 0.05, 5, "sd with which a person's speed changes")] = 0.7
    walking: Annotated[float, Meta("m/s", 0.01, 3, "sd of a speed of which nothing is known")] = 0.3
    gate: Annotated[float, Meta("χ²", 1, 50, "squared distance of a measurement, at most; 99.7 % at 2 dof")] = 11.8
    wide_gate: Annotated[
        float, Meta("m", 0.1, 3, "farther from the prediction a person is not the one lost a moment ago")
    ] = 0.6
    patience: Annotated[float, Meta("s", 0.2, 20, "time that a person may be hidden")] = 2.5
    unseen: Annotated[
        float, Meta("s", 0.5, 60, "time that legs alone are believed while the camera should see the person")
    ] = 8.0
    known: Annotated[float, Meta("", 0.05, 0.99, "K that is enough for a person who is expected there")] = 0.5
    alike: Annotated[
        float, Meta("", 0, 1, "probability by looks alone below which it is not the followed person")
    ] = 0.15


@message
class TrackedPerson:
    """The person as they are known now."""

    stamp: float  # [s] of the newest measurement
    position: Array  # (2,) [m] world, by all senses
    covariance: Array  # (2, 2) [m²]
    velocity: Array  # (2,) [m/s]
    rectangle: Rectangle | None = None  # in the newest picture in which they were found
    rectangle_stamp: float = -math.inf  # [s] of that picture
    laser: Array | None = None  # (2,) [m] world: by the legs alone
    camera: Ray | None = None
    sound: Ray | None = None
    used: tuple[Sense, ...] = ()
    state: Literal["seen", "hidden"] = "seen"
