"""The part of a scan that the gate's guard needs: the nearest points around the robot, a hundred of a thousand."""

from __future__ import annotations

import math

import numpy as np

from core.gate.guard import HORIZON
from core.geometry import Pose
from core.message import Array
from core.perception.landmarks.deskew import deskew
from core.sensors import Laser, Scan, SensorFrame

SECTOR = math.radians(2.0)  # one point each
READABLE = 0.1  # share of beams that must say something, even if it is "nothing there"
REPEATS = 2  # equal scans in a row, on the move, that mean the laser hangs …
RECENT = 0.2  # [s] for which what another laser saw counts
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


def field_of(*lasers: Laser) -> float:
    """Return the angle that the lasers see to either side of the robot's front, at least [rad]; π: all around."""
    first = [laser.mounting.heading + laser.angle_min for laser in lasers]
    seen = [(one, one + (laser.beams - 1) * laser.angle_step) for one, laser in zip(first, lasers, strict=True)]
    return min(_reach(seen), _reach([(-last, -first) for first, last in seen]))


def _reach(seen: list[tuple[float, float]]) -> float:
    """Return how far, from straight ahead to the left, every direction lies in one of these intervals [rad]."""
    turned = [(first + turn, last + turn) for first, last in seen for turn in (-math.tau, 0.0, math.tau)]
    reach = 0.0
    while (further := max((last for first, last in turned if first <= reach + SECTOR), default=0.0)) > reach:
        reach = further
    return min(reach, math.pi)


class NearField:
    """Points near the robot by all its lasers, for the gate's guard."""

    def __init__(self, lasers: tuple[Laser, ...]) -> None:
        self._lasers = {laser.name: laser for laser in lasers}
        self._first = lasers[0] if lasers else None
        self._freshness = {laser.name: Freshness() for laser in lasers}
        self._seen: dict[str, tuple[float, Pose, Array]] = {}  # stamp [s], odometry, points (N, 2) [m] of each laser

    def see(self, frame: SensorFrame, *, moving: bool) -> tuple[list[tuple[float, float]], float] | None:
        """One frame → nearest points (x, y) [m] in the robot's frame and the field [rad] in which they are known.

        The newest scans of the other lasers count too, as far as they are recent. None: nothing new, or nothing that
        can be believed.
        """
        scan = frame.scan
        if scan is None or self._first is None:
            return None
        laser = self._lasers.get(scan.laser, self._first)
        if not self._freshness[laser.name].shows(scan, moving=moving):
            self._seen.pop(laser.name, None)
            return None
        here = frame.wheels.odometry if frame.wheels is not None else Pose()
        points = near_points(scan, laser, frame)
        self._seen[laser.name] = frame.stamp, here, np.array(points).reshape(-1, 2)
        recent = {name: one for name, one in self._seen.items() if 0.0 <= frame.stamp - one[0] <= RECENT}
        for name, (_, there, others) in recent.items():
            if name != laser.name:
                moved = (here.inverse() @ there).apply(others)
                points += [(round(float(x), 4), round(float(y), 4)) for x, y in moved]
        return points, field_of(*(self._lasers[name] for name in recent))


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
