"""Odometry: the robot's move from frame to frame, by its wheels or, where it has none, by its scans."""

from __future__ import annotations

from core.sensors import Laser, SensorFrame, Wheels
from core.slam.motion import Motion, MotionSettings, WheelTrack
from core.slam.scan_matching.scan_odometry import ScanOdometry, ScanOdometrySettings


class Odometry:
    """One `update` for every frame. A frame without wheels takes the last ones; before any wheels the scans count,
    those of the first laser: two that look apart do not fit on each other.
    """

    def __init__(self, laser: Laser | None, motion: MotionSettings, scans: ScanOdometrySettings) -> None:
        self._track = WheelTrack(motion)
        self._laser = laser or Laser()
        self._scans = ScanOdometry(self._laser, scans)
        self._wheels: Wheels | None = None

    def update(self, frame: SensorFrame) -> Motion:
        """One frame → the move since the frame before."""
        self._wheels = frame.wheels or self._wheels
        if self._wheels is not None:
            return Motion(self._track.step(frame.stamp, self._wheels), self._wheels)
        if frame.scan is None or frame.scan.laser not in ("", self._laser.name):
            return Motion(wheels=self._scans.wheels, by_scans=True, scanned=self._scans.taken)
        increment = self._scans.update(frame.scan)
        return Motion(increment, self._scans.wheels, by_scans=True, scanned=self._scans.taken)
