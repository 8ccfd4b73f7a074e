"""The part of a scan that the gate's guard needs: the nearest points around the robot, a hundred of a thousand."""

from __future__ import annotations

import math

import numpy as np

from core.gate.guard import HORIZON
from core.message import Array
from core.perception.landmarks.deskew import deskew
from core.sensors import Laser, Scan, SensorFrame

SECTOR = math.radians(2.0)  # one point each
READABLE = 0.1  # share of beams that must say something, even if it is "nothing there"
REPEATS = 2  # equal scans in a row, on the move, that mean the laser hangs …
RESTED = 20  # … until another one comes, or it has stood for so many: the gate has given up by then


def near_points(scan: Scan, laser: Laser, frame: SensorFrame) -> list[tuple[float, float]]:
    """Scan → in every sector of 2° the nearest point within 1.5 m (x, y) [m], robot frame at the frame's stamp."""
    points, _ = deskew(scan, laser, frame.wheels, frame.stamp)
    distances = np.hypot(points[:, 0], points[:, 1])
    order = np.argsort(distances)
    order = order[distances[order] <= HORIZON]
    sectors = np.floor(np.arctan2(points[order, 1], points[order, 0]) / SECTOR)
    _, first = np.unique(sectors, return_index=True)
    return [(round(float(x), 4), round(float(y), 4)) for x, y in points[order[first]]]


def field_of(laser: Laser) -> float:
    """Return the angle that the laser sees to either side of the robot's front, at least [rad]; π: all around."""
    first = laser.mounting.heading + laser.angle_min
    last = first + (laser.beams - 1) * laser.angle_step
    if last - first > 2 * math.pi - 2 * SECTOR:
        return math.pi
    return max(0.0, min(-first, last, math.pi))


class Freshness:
    """Tells a laser that sees from one that is blind or hangs."""

    def __init__(self) -> None:
        self._last: Array | None = None
        self._repeats = self._rested = 0
        self._nearest = 0.0  # [m], of the last scan with an echo

    def shows(self, scan: Scan, *, moving: bool) -> bool:
        """Return whether a scan shows the present surroundings.

        Enough beams came back, and not the same as before on the move. A scan without a single echo is believed only
        after one in which nothing was near: what was near does not vanish from one scan to the next, and a laser that
        never showed an echo may see nothing at all.
        """
        repeated = self._last is not None and np.array_equal(self._last, scan.ranges, equal_nan=True)
        self._rested = self._rested + 1 if repeated and not moving else 0
        if not repeated or self._rested >= RESTED:
            self._repeats = 0
        elif moving:
            self._repeats += 1
        self._last = scan.ranges
        echoes = scan.ranges[scan.valid]
        if len(echoes):
            self._nearest = float(echoes.min())
        elif self._nearest <= HORIZON:
            return False
        readable = int(np.count_nonzero(scan.valid | np.isposinf(scan.ranges)))
        return self._repeats < REPEATS and readable >= READABLE * len(scan.ranges) > 0
