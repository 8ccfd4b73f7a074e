"""The part of a scan that the gate's guard needs: the nearest points around the robot, a hundred of a thousand."""

import math
from collections import deque
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from core.gate import Gate
from core.gate.guard import HORIZON_M
from core.geometry import Pose
from core.message import Array
from core.perception.landmarks.deskew import deskew
from core.sensors import Laser, Scan, SensorFrame, Wheels
from core.sensors.checks import MAX_AGE_S, MAX_LEAD_S

SECTOR_RAD = math.radians(2.0)  # [rad] of which one point is kept, the nearest
MIN_READABLE_SHARE = 0.1  # share of beams that must say something, even if it is "nothing there"
MIN_REPEATS = 2  # equal scans in a row, on the move, that mean the laser hangs
RESTED_SCANS = 20  # equal ones at rest after which it no longer does: the gate has given up by then
MAX_OTHER_SCAN_AGE_S = 0.2  # up to which another laser's scan counts too
PUNCTUAL_S = 0.05  # of a scan's age, up to which the wheels' present twist says how far the robot went since then
FORGOTTEN_S = 2.0  # after which a laser that was late and is silent holds up the others no longer


class NearScan(NamedTuple):
    """The part of a scan that the guard needs."""

    points: list[tuple[float, float]]  # (x, y) [m], robot frame
    field: float  # [rad] to either side of the front in which they are known
    age: float  # [s] of the scan, by its stamp


def near_points(scan: Scan, laser: Laser, frame: SensorFrame) -> list[tuple[float, float]]:
    """Scan → in every sector of 2° the nearest point within 1.5 m (x, y) [m], robot frame at the frame's stamp."""
    points, _ = deskew(scan, laser, frame.wheels, frame.stamp)
    distances = np.hypot(points[:, 0], points[:, 1])
    order = np.argsort(distances)
    order = order[distances[order] <= HORIZON_M]
    sectors = np.floor(np.arctan2(points[order, 1], points[order, 0]) / SECTOR_RAD)
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
    while (further := max((last for first, last in turned if first <= reach + SECTOR_RAD), default=0.0)) > reach:
        reach = further
    return min(reach, math.pi)


class NearField:
    """Points near the robot by all its lasers, for the gate's guard."""

    def __init__(self, lasers: tuple[Laser, ...]) -> None:
        self._lasers = {laser.name: laser for laser in lasers}
        self._first = lasers[0] if lasers else None
        self._freshness = {laser.name: Freshness() for laser in lasers}
        # stamp [s], odometry, points (N, 2) [m] of each laser
        self._seen: dict[str, tuple[float, Pose | None, Array]] = {}
        self._taken: dict[str, float] = {}  # when the newest scan of each laser was measured [s]
        self._stamp = -math.inf  # [s] of the newest frame
        self._rolled: deque[tuple[float, Pose]] = deque()  # stamp [s], odometry of the newest frames
        self._untimely: dict[str, tuple[float, float]] = {}  # age [s] of a laser's newest scan, at this stamp [s]

    @property
    def untimely(self) -> float | None:
        """The age [s] of the newest scan of a laser that is late; less than 0: it is stamped ahead; None: none is."""
        return next((age for age, _ in self._untimely.values()), None)

    def see(self, frame: SensorFrame, *, moving: bool) -> NearScan | None:
        """One frame → nearest points (x, y) [m] in the robot's frame, the field in which they are known, their age.

        The newest scans of the other lasers count too, as far as they are recent. None: nothing new, or nothing that
        can be believed: a laser that is blind, hangs or is late, and any other while one is late.
        """
        self._roll(frame)
        scan = frame.scan
        if scan is None or self._first is None:
            return None
        laser = self._lasers.get(scan.laser, self._first)
        scan = replace(scan, stamp=scan.stamp + laser.time_offset)
        timely = self._is_timely(scan, laser.name, frame.stamp)
        if timely and scan.newest < self._taken.get(laser.name, -math.inf):
            return None  # another overtook it
        if not timely or not self._freshness[laser.name].shows(scan, moving=moving):
            self._seen.pop(laser.name, None)
            return None
        self._taken[laser.name] = scan.newest
        if self._untimely:
            return None
        here = frame.wheels.odometry if frame.wheels is not None else None
        age = max(frame.stamp - scan.newest, 0.0)
        seen = replace(scan, stamp=scan.stamp - max(scan.newest - frame.stamp, 0.0))
        points = near_points(seen, laser, replace(frame, wheels=self._way(frame, age)))
        self._seen[laser.name] = frame.stamp, here, np.array(points).reshape(-1, 2)
        recent = {
            name: one
            for name, one in self._seen.items()
            if 0.0 <= frame.stamp - one[0] <= MAX_OTHER_SCAN_AGE_S and (one[1] is None) == (here is None)
        }
        for name, (_, there, others) in recent.items():
            if name != laser.name:
                moved = others if here is None or there is None else (here.inverse() @ there).apply(others)
                points += [(round(float(x), 4), round(float(y), 4)) for x, y in moved]
        return NearScan(points, field_of(*(self._lasers[name] for name in recent)), age)

    def _is_timely(self, scan: Scan, name: str, now: float) -> bool:
        """Return whether a scan is young enough to drive by and not stamped ahead; False for a stamp that is NaN."""
        self._untimely.pop(name, None)
        if scan.oldest - now <= MAX_LEAD_S and now - scan.newest <= MAX_AGE_S:
            return True
        if math.isfinite(scan.stamp):
            self._untimely[name] = now - (scan.newest if scan.newest < now else scan.oldest), now
        return False

    def _roll(self, frame: SensorFrame) -> None:
        """Note how far the wheels have rolled; a clock that ran backwards was reset."""
        if frame.stamp < self._stamp:
            self._rolled.clear()
            self._taken.clear()
            self._seen.clear()
        self._stamp = frame.stamp
        if frame.wheels is not None:
            self._rolled.append((frame.stamp, frame.wheels.odometry))
        while self._rolled and frame.stamp - self._rolled[0][0] > MAX_AGE_S:
            self._rolled.popleft()
        for name, (_, at) in list(self._untimely.items()):
            if not 0.0 <= frame.stamp - at <= FORGOTTEN_S:
                del self._untimely[name]

    def _way(self, frame: SensorFrame, age: float) -> Wheels | None:
        """The wheels with the mean twist of the last `age` [s]: a robot that slows down came nearer."""
        then = next((one for one in self._rolled if one[0] >= frame.stamp - age), None)
        if frame.wheels is None or then is None or age <= PUNCTUAL_S or frame.stamp <= then[0]:
            return frame.wheels
        elapsed, moved = frame.stamp - then[0], then[1].inverse() @ frame.wheels.odometry
        speed = math.copysign(math.hypot(moved.x, moved.y), moved.x) / elapsed
        return replace(frame.wheels, speed=speed, turn_rate=moved.heading / elapsed)


def show(gate: Gate, field: NearField, frame: SensorFrame, now: float) -> None:
    """Show a frame to a gate in this process at `now` [s], as the driver's process shows it to its own."""
    near = field.see(frame, moving=gate.twist.moves)
    if near is not None:
        gate.see(near.points, now, near.field, near.age)
    elif field.untimely is not None:
        gate.see_untimely(field.untimely, now)
    if frame.trouble:
        gate.see_trouble(now)
    gate.touch(frame.contact, now)


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
        if not repeated or self._rested >= RESTED_SCANS:
            self._repeats = 0
        elif moving:
            self._repeats += 1
        self._last = scan.ranges
        echoes = scan.ranges[scan.valid]
        if len(echoes):
            self._nearest = float(echoes.min())
        elif self._nearest <= HORIZON_M:
            return False
        readable = int(np.count_nonzero(scan.valid | np.isposinf(scan.ranges)))
        return self._repeats < MIN_REPEATS and readable >= MIN_READABLE_SHARE * len(scan.ranges) > 0
