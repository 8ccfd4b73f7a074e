"""The 2-D laser rangefinder."""

import math

import numpy as np

from core.geometry import Pose, Transform
from core.message import Array, message
from core.sensors.checks import are_finite, is_array

MIN_BEAMS, MAX_BEAMS = 2, 20_000  # of a scan
MAX_SWEEP_S = 2.0  # [s] from the first beam of a scan to its last
MAX_STAMP_S = 1e11  # [s]
MAX_TILT_RAD = math.radians(20)  # of a laser whose plane is taken for level


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
    rate: float | None = 10.0  # [Hz]; None: not known
    time_step: float = 0.1 / 1024  # [s] between neighbouring beams
    time_offset: float = 0.0  # [s] to add to the scans' stamps, to be on the odometry's clock


@message
class Placed:
    """The mounting of a laser on the robot, in the plane."""

    pose: Pose = Pose()  # robot_from_laser
    height: float = 0.12  # [m]
    upside_down: bool = False
    tilt: float = 0.0  # [rad] of its plane from the floor's

    @property
    def level(self) -> bool:
        """True where it sees what is around, not the floor and not a vertical slice."""
        return self.tilt < MAX_TILT_RAD


def flat(robot_from_laser: Transform) -> Placed:
    """A laser's frame on the robot → its mounting in the plane."""
    x, y, z = (float(number) for number in robot_from_laser.translation)
    forward = robot_from_laser.rotation[:, 0]
    return Placed(
        pose=Pose(x, y, math.atan2(float(forward[1]), float(forward[0]))),
        height=z,
        upside_down=bool(robot_from_laser.rotation[2, 2] < -0.5),
        tilt=math.acos(min(1.0, abs(float(robot_from_laser.rotation[2, 2])))),
    )


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

    @property
    def oldest(self) -> float:
        """When the first of its beams was measured [s], on the robot's clock; it may be the leftmost one."""
        return self.stamp + min(self.time_step, 0.0) * (len(self.ranges) - 1)

    @property
    def newest(self) -> float:
        """When the last of its beams was measured [s]."""
        return self.stamp + max(self.time_step, 0.0) * (len(self.ranges) - 1)

    @property
    def malformation(self) -> str:
        """Describe what is wrong with the form of this scan; "" where nothing is.

        Whatever a driver put into the fields is answered, not raised.
        """
        if not is_array(self.ranges, 1, "fiu"):
            return "its ranges are no row of numbers"
        if not are_finite(self.stamp) or abs(self.stamp) > MAX_STAMP_S:
            return "its time cannot be"
        if found := beams_malformation(len(self.ranges), self.angle_min, self.angle_step):
            return found
        if not are_finite(self.time_step) or abs(self.time_step) * len(self.ranges) > MAX_SWEEP_S:
            return "the time between its beams cannot be"
        bounded = are_finite(self.range_min) and (are_finite(self.range_max) or self.range_max == math.inf)
        if not bounded or not self.range_min < self.range_max:
            return "its limits of range leave nothing between them"
        return ""


def beams_malformation(beams: int, angle_min: float, angle_step: float) -> str:
    """Describe what is wrong with the number of beams of a scan or their angles [rad]; "" where nothing is."""
    if not MIN_BEAMS <= beams <= MAX_BEAMS:
        return "it has no beams" if beams == 0 else f"it has {beams} beam{'s' * (beams > 1)}"
    if not are_finite(angle_min, angle_step) or angle_step == 0:
        return "its angles are no numbers"
    if abs(angle_step) * (beams - 1) > 2 * math.pi + 0.1 or abs(angle_min) > 4 * math.pi:
        return "its beams go round more than once"
    return ""
