"""The person who is followed, as known at one instant, and the numbers that following takes."""

import math
from dataclasses import dataclass
from typing import Annotated, Literal

from core.geometry import Ray
from core.message import Array, message
from core.perception.people.detector import Rectangle
from core.perception.people.fusion import Sense
from core.setting import Meta, Section


@dataclass(frozen=True)
class TrackSettings(Section):
    """Birth, gate and death of the one who is followed.

    Watch:
        patience: persons lost behind furniture (then raise it)
        unseen: chairs followed for persons (then lower it)
    """

    births: int = 2  # pictures with the person in them until the person is confirmed
    acceleration: float = 0.7  # [m/s²] sd with which a person's speed changes
    walking: float = 0.3  # [m/s] sd of a speed of which nothing is known
    gate: float = 11.8  # [χ²] squared distance of a measurement, at most; 99.7 % at 2 dof
    wide_gate: float = 0.6  # [m] farther from the prediction a person is not the one lost a moment ago
    known: float = 0.5  # K that is enough for a person who is expected there
    alike: float = 0.15  # probability by looks alone below which it is not the followed person
    patience: Annotated[float, Meta("s", 0.2, 20, "time that a person may be hidden")] = 2.5
    unseen: Annotated[
        float, Meta("s", 0.5, 60, "time that legs alone are believed while the camera should see the person")
    ] = 8.0


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
