"""The recent motion: late readings are seen from the pose at which they were taken, then moved to the present one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from core.geometry import Pose
from core.message import Array
from core.perception.landmarks.landmarks import Sighting
from core.sensors import Laser, Scan, SensorFrame, Wheels
from core.slam.motion import Increment, MotionSettings, WheelTrack
from core.slam.motion_history import MotionHistory, carried
from core.slam.scan_matching.scan_odometry import ScanOdometry, ScanOdometrySettings

LATE = 0.05  # [s] after its last beam from when a scan is late: until then the wheels' twist suffices
AROUND = 0.1  # [s] over which the twist at some time is measured


class MotionBuffer:
    """The moves of the last two seconds."""

    def __init__(self, motion: MotionSettings) -> None:
        self._track = WheelTrack(motion)
        self._history = MotionHistory()

    def feel(self, frame: SensorFrame) -> None:
        """Take one frame."""
        self._history.add(frame.stamp, self._track.step(frame))

    def taken(self, scan: Scan, now: float) -> float:
        """Return the time [s] whose pose suits the scan best: `now`, or the last beam's time of a late scan."""
        end = float(scan.times[-1])
        return end if now - end > LATE and self._history.between(end, now) is not None else now

    def wheels(self, then: float, now: float, wheels: Wheels | None) -> Wheels | None:
        """The wheels at a time `then` [s]; `wheels` are those of `now`."""
        move = self._history.between(then - AROUND, then) if then < now and wheels is not None else None
        if wheels is None or move is None:
            return wheels
        forward = float(np.copysign(np.hypot(move.pose.x, move.pose.y), move.pose.x))
        return Wheels(odometry=wheels.odometry, speed=forward / AROUND, turn_rate=move.pose.heading / AROUND)

    def moved(self, then: float, now: float) -> Increment | None:
        """The move from one time to another [s], either way round; None where it is not known."""
        if now >= then:
            return self._history.between(then, now)
        move = self._history.between(now, then)
        return None if move is None else Increment(move.pose.inverse())

    def bring(
        self, then: float, now: float, sightings: tuple[Sighting, ...], ends: Array
    ) -> tuple[tuple[Sighting, ...], Array]:
        """Sightings and points (N, 2) [m] in the robot frame of `then` → in that of `now`."""
        move = self.moved(then, now)
        if move is None or move.pose == Pose():
            return sightings, ends
        return tuple(carried(sighting, move, now) for sighting in sightings), move.pose.inverse().apply(ends)


class OdometrySource:
    """Gives every frame wheels: its own, the last ones, or those that the scans stand in for."""

    def __init__(self, laser: Laser | None, settings: ScanOdometrySettings) -> None:
        self._scans = ScanOdometry(laser or Laser(), settings)
        self._wheels: Wheels | None = None

    def feel(self, frame: SensorFrame) -> tuple[SensorFrame, Increment | None]:
        """One frame → the frame with wheels, and the move where it does not follow from them."""
        if frame.wheels is not None:
            self._wheels = frame.wheels
            return frame, None
        if self._wheels is not None:
            return replace(frame, wheels=self._wheels), None
        move = Increment() if frame.scan is None else self._scans.update(frame.scan, frame.stamp)
        return replace(frame, wheels=self._scans.wheels), move
