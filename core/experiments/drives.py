"""Interface of drives for experiments over many of them, independent of their source."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from core.experiments.course_traces import Trace
from core.message import Array

PLAIN = "dead_reckoning"
FIGURED = "ekf_slam"


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
    def setup(self) -> dict[str, Any]:
        """The set-up, ready for JSON."""
        ...

    @property
    def words(self) -> str:
        """The set-up in a line."""
        ...

    def traces(self, number: int) -> dict[str, Trace]:
        """One drive through every estimator, by row."""
        ...
