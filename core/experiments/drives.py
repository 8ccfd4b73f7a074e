"""Interface of drives for experiments over many of them, independent of their source."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NotRequired, Protocol, TypedDict

import numpy as np

from core.experiments.course_traces import Trace
from core.message import Array

PLAIN = "dead_reckoning"
FIGURED = "ekf_slam"


class DriveSetup(TypedDict):
    """The set-up of drives, as JSON."""

    through: str  # "drawn" | "sensors"
    mode: str  # the filter's form
    still_start: bool
    ids: str
    speed_m_s: float
    wheelbase_m: float
    speed_sd_m_s: float
    steer_sd_deg: float
    data: NotRequired[str | None]  # of drawn ones: the file of the draws …
    field: NotRequired[str]  # … what is seen of the room …
    range_sd_m: NotRequired[float]
    bearing_sd_deg: NotRequired[float]
    place: NotRequired[str]  # through the sensors: the simulated place …
    laser_noise: NotRequired[str]  # … and its laser


@dataclass(frozen=True)
class DriveSurroundings:
    """Surroundings to draw in the picture."""

    corners: Array = field(default_factory=lambda: np.zeros((0, 2)))  # (N, 2) [m]
    walls: Array = field(default_factory=lambda: np.zeros((0, 2, 2)))  # (W, 2, 2) [m]: ends


class Drives(Protocol):
    """Drives by their number; the same number is always the same drive."""

    @property
    def rows(self) -> tuple[str, ...]:
        """The estimators, PLAIN and FIGURED first."""
        ...

    @property
    def room(self) -> DriveSurroundings:
        """The place of the drives."""
        ...

    @property
    def setup(self) -> DriveSetup:
        """The set-up, ready for JSON."""
        ...

    @property
    def words(self) -> str:
        """The set-up in a line."""
        ...

    def traces(self, number: int) -> dict[str, Trace]:
        """One drive through every estimator, by row."""
        ...
