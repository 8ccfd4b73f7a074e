"""Feeling how far the robot has moved: by its wheels, or by its scans where there are no wheels."""

from __future__ import annotations

from dataclasses import replace

from core.sensors import Laser, SensorFrame, Wheels
from core.slam.motion import Increment
from core.slam.scan_odometry import ScanOdometry, ScanOdometrySettings


class Feet:
    """Gives every frame wheels: its own, the last ones, or those that the scans stand in for."""

    def __init__(self, laser: Laser | None, settings: ScanOdometrySettings) -> None:
        self._scans = ScanOdometry(laser or Laser(), settings)
        self._wheels: Wheels | None = None

    def feel(self, frame: SensorFrame) -> tuple[SensorFrame, Increment | None]:
        """One frame → the frame with wheels, and the move if it is not these that tell it."""
        if frame.wheels is not None:
            self._wheels = frame.wheels
            return frame, None
        if self._wheels is not None:
            return replace(frame, wheels=self._wheels), None
        move = Increment() if frame.scan is None else self._scans.update(frame.scan, frame.stamp)
        return replace(frame, wheels=self._scans.wheels), move
