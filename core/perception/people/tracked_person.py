"""The person who is followed, as known at one instant, and the numbers that following takes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from core.errors import BadInput
from core.message import Array, message
from core.perception.people.detector import Rectangle
from core.perception.people.fusion import Ray, Sense


@dataclass(frozen=True)
class TrackSettings:
    """Birth, gate and death of the one who is followed."""

    births: int = 2  # pictures with the person in them until it is believed
    acceleration: float = 0.7  # [m/s²] sd with which a person's speed changes
    walking: float = 0.3  # [m/s] sd of a speed of which nothing is known
    gate: float = 11.8  # chi-square, 2 degrees of freedom, 99.7 %
    wide_gate: float = 0.6  # [m] farther from the prediction, a person is not the one lost a moment ago
    patience: float = 2.5  # [s] that a person may be hidden
    unseen: float = 8.0  # [s] that legs alone are believed while the camera should see the person
    known: float = 0.5  # K that is enough for a person who is expected there
    alike: float = 0.6  # share of the usual similarity of the colours, below which it is another person

    def __post_init__(self) -> None:
        for name, (low, high) in BOUNDS.items():
            if not low <= getattr(self, name) <= high:
                raise BadInput(f"{name} must lie between {low:g} and {high:g}.")


BOUNDS = {
    "births": (1, 20),
    "acceleration": (0.05, 5.0),
    "walking": (0.01, 3.0),
    "gate": (1.0, 50.0),
    "wide_gate": (0.1, 3.0),
    "patience": (0.2, 20.0),
    "unseen": (0.5, 60.0),
    "known": (0.05, 0.99),
    "alike": (0.0, 1.0),
}


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
