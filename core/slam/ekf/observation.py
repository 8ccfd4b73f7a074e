"""One scan's sightings and what the filter expected."""

from dataclasses import dataclass
from typing import Literal

from core.message import Array
from core.perception.landmarks.landmarks import Sighting

Fate = Literal["matched", "tentative", "new", "ignored"]


@dataclass
class Observation:
    """M sightings, N landmarks; and what became of the sightings."""

    seen: tuple[Sighting, ...]
    readings: Array  # (M, 2) range [m], bearing [rad]
    noises: Array  # (M, 2, 2)
    expectations: Array  # (N, 2)
    states: Array  # (N, 2, 2): covariance of the expectation, without the sensor's noise
    fates: list[tuple[Fate, int | None]]
