"""The 2-D laser rangefinder."""

from __future__ import annotations

import numpy as np

from core.geometry import Pose
from core.message import Array, message


@message
class Laser:
    """A laser and its mounting."""

    name: str = "laser"
    mounting: Pose = Pose()  # robot_from_laser
    height: float = 0.12  # [m] of the scanning plane above the floor
    beams: int = 682
    angle_min: float = -2.0923  # [rad] of the first beam; right to left
    angle_step: float = 2 * np.pi / 1024  # [rad]
    range_min: float = 0.02  # [m]
    range_max: float = 5.6  # [m]
    rate: float = 10.0  # [Hz]
    time_step: float = 0.1 / 1024  # [s] between neighbouring beams
    time_offset: float = 0.0  # [s] to add to the scans' stamps, to be on the odometry's clock


@message
class Scan:
    """One turn of the mirror, right to left."""

    stamp: float  # [s] of the first beam
    laser: str = ""  # name of the laser that took it; "": of the only one
    ranges: Array  # (N,) [m]; NaN = no measurement (neither hit nor free), inf = nothing within range_max
    angle_min: float  # [rad] of the first beam, in the laser frame
    angle_step: float  # [rad]
    range_min: float = 0.02  # [m]
    range_max: float = 5.6  # [m]
    time_step: float = 0.0  # [s] between neighbouring beams; 0: all at once

    @property
    def angles(self) -> Array:
        """Bearing of every beam (N,) [rad] in the laser frame."""
        return self.angle_min + self.angle_step * np.arange(len(self.ranges))

    @property
    def valid(self) -> Array:
        """(N,) bool: beams that hit something."""
        return np.isfinite(self.ranges) & (self.ranges >= self.range_min) & (self.ranges <= self.range_max)

    @property
    def times(self) -> Array:
        """(N,) [s]: when each beam was measured, on the robot's clock."""
        return self.stamp + self.time_step * np.arange(len(self.ranges))
