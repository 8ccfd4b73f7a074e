"""Odometry: the robot's move from frame to frame, by its wheels or, where they cannot be right, by its scans."""

import math
from dataclasses import replace

from core.geometry import Pose, wrap
from core.sensors import Fault, Laser, Scan, SensorFrame, Wheels
from core.slam.motion import Increment, Motion, MotionSettings, WheelTrack, widened
from core.slam.scan_matching.agreement import SenseAgreement
from core.slam.scan_matching.scan_odometry import ScanOdometry, ScanOdometrySettings
from core.slam.scan_matching.wall_shapes import WallShapes

RESTARTED = "odometry.restarted"  # code of the fault of a base that was
RESTART_SD_M, RESTART_SD_RAD = 0.3, math.radians(20)  # of what a base did while it was not heard
SCAN_SD_M, SCAN_SD_RAD = 0.1, math.radians(6)  # from scan to scan, where the wheels are not believed
MAX_CARRIED_S = 0.5  # over which the speed by scans is carried on


class Odometry:
    """One `update` for every frame. A frame without wheels takes the last ones; before any wheels the scans count,
    those of the first laser: two that look apart do not fit on each other.

    Where wheels and scans contradict each other so that the wheels cannot be right, the speed by scans stands in.
    """

    def __init__(self, laser: Laser | None, motion: MotionSettings, scans: ScanOdometrySettings) -> None:
        self._track = WheelTrack(motion)
        self._laser = laser or Laser()
        self._scans = ScanOdometry(self._laser, scans)
        self._wheels: Wheels | None = None
        self._stamp = 0.0  # [s] of the newest frame
        self.agreement, self._shapes = SenseAgreement(self._laser), WallShapes(self._laser)

    @property
    def faults(self) -> tuple[Fault, ...]:
        """Contradictions between wheels and scans, and within the scans, that were found."""
        return (*self.agreement.faults, *self._shapes.faults)

    def update(self, frame: SensorFrame) -> Motion:
        """One frame → the move since the frame before."""
        self._wheels = frame.wheels or self._wheels
        own = frame.scan is not None and frame.scan.laser in ("", self._laser.name)
        scan = frame.scan if own else None
        if scan is not None:
            self._shapes.update(scan, self._wheels.turn_rate if self._wheels else self._scans.wheels.turn_rate)
        if self._wheels is not None:
            return self._by_wheels(frame, self._wheels, scan)
        if scan is None:
            return Motion(wheels=self._scans.wheels, by_scans=True, scanned=self._scans.taken)
        increment = self._scans.update(scan)
        return Motion(increment, self._scans.wheels, by_scans=True, scanned=self._scans.taken)

    def _by_wheels(self, frame: SensorFrame, wheels: Wheels, scan: Scan | None) -> Motion:
        elapsed, self._stamp = frame.stamp - self._stamp, frame.stamp
        increment = self._track.step(frame.stamp, wheels)
        self.agreement.update(frame.stamp, wheels, scan, fresh=frame.wheels is not None)
        restarted = any(one.code == RESTARTED for one in frame.faults)
        if restarted:
            increment = widened(increment, RESTART_SD_M, RESTART_SD_RAD)
        if not self.agreement.distrusts:
            return Motion(increment, wheels, restarted=restarted)
        return self._instead_of(increment, wheels, min(elapsed, MAX_CARRIED_S), scan is not None)

    def _instead_of(self, increment: Increment, wheels: Wheels, elapsed: float, scanned: bool) -> Motion:
        """The move by the speed of the scans; `increment` is what the wheels claim."""
        missed, rate = self.agreement.missed, self.agreement.velocity or Pose()
        if missed is not None:
            move = widened(Increment(increment.pose @ missed), RESTART_SD_M, RESTART_SD_RAD)
        else:
            move = Increment(Pose(elapsed * rate.x, elapsed * rate.y, wrap(elapsed * rate.heading)))
            move = widened(move, SCAN_SD_M, SCAN_SD_RAD) if scanned else move
        return Motion(move, replace(wheels, speed=rate.x, turn_rate=rate.heading))
