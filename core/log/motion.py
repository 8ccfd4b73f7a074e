"""Motion between two sightings, composed from many small steps, with the covariance the log's own noise gives it."""

from __future__ import annotations

import math

import numpy as np

from core.geometry import Pose
from core.message import Array


class Motion:
    """Composes increments in the frame where the motion began."""

    def __init__(self) -> None:
        self._pose = Pose()  # start_from_here
        self._covariance: Array = np.zeros((3, 3))

    def add(self, increment: Pose, covariance: Array) -> None:
        """Append an increment and its covariance (3, 3), both in the present robot frame: C ← F C Fᵀ + G Q Gᵀ."""
        c, s = math.cos(self._pose.heading), math.sin(self._pose.heading)
        after = self._pose @ increment
        carry = np.array([[1, 0, self._pose.y - after.y], [0, 1, after.x - self._pose.x], [0, 0, 1]])
        turned = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        self._covariance = carry @ self._covariance @ carry.T + turned @ covariance @ turned.T
        self._pose = after

    def take(self) -> tuple[Pose, Array]:
        """What was composed so far, and begin anew."""
        pose, covariance = self._pose, self._covariance
        self._pose, self._covariance = Pose(), np.zeros((3, 3))
        return pose, covariance
