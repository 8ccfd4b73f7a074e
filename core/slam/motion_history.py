"""The moves of the last moments, so that what is seen late is applied where it was seen."""

from collections import deque
from dataclasses import replace

import numpy as np

from core.geometry import Pose, rotation, wrap
from core.message import Array
from core.perception.landmarks.landmarks import Sighting
from core.sensors import Scan, Wheels
from core.slam.motion import Increment

SPAN_S = 2.0  # that are kept
LATE_SCAN_S = 0.05  # after its last beam from when a scan is late: until then the wheels' twist suffices
TWIST_WINDOW_S = 0.1  # over which the twist at some time is measured


class MotionHistory:
    """Moves by the time at which each ended."""

    def __init__(self) -> None:
        self._moves: deque[tuple[float, Increment]] = deque()
        self._since = float("inf")  # [s] from when on every move is known

    def add(self, stamp: float, move: Increment) -> None:
        """Add the move that ended at `stamp` [s] and began where the last one ended. A stamp before it clears all."""
        if not self._moves or stamp < self._moves[-1][0]:
            self._moves.clear()
            self._since = stamp
        self._moves.append((stamp, move))
        while stamp - self._moves[0][0] > SPAN_S:
            self._since = self._moves.popleft()[0]

    def between(self, start: float, end: float) -> Increment | None:
        """The move from `start` to `end` [s]; None where it is not known. Inside one move the motion is even."""
        if not self._moves or start < self._since or end > self._moves[-1][0] or end < start:
            return None
        total, began = Increment(), self._since
        for stamp, move in self._moves:
            first, last = max(start, began), min(end, stamp)
            if last > first:
                total = total.then(_part(move, (first - began) / (stamp - began), (last - began) / (stamp - began)))
            began = stamp
        return total

    def taken(self, scan: Scan, now: float) -> float:
        """Return the time [s] whose pose suits the scan best: `now`, or the last beam's time of a late scan."""
        end = float(scan.times[-1])
        return end if now - end > LATE_SCAN_S and self.between(end, now) is not None else now

    def wheels(self, then: float, now: float, wheels: Wheels | None) -> Wheels | None:
        """The wheels at a time `then` [s]; `wheels` are those of `now`."""
        move = self.between(then - TWIST_WINDOW_S, then) if then < now and wheels is not None else None
        if wheels is None or move is None:
            return wheels
        forward = float(np.copysign(np.hypot(move.pose.x, move.pose.y), move.pose.x))
        return Wheels(
            odometry=wheels.odometry, speed=forward / TWIST_WINDOW_S, turn_rate=move.pose.heading / TWIST_WINDOW_S
        )

    def moved(self, then: float, now: float) -> Increment | None:
        """The move from one time to another [s], either way round; None where it is not known."""
        if now >= then:
            return self.between(then, now)
        move = self.between(now, then)
        return None if move is None else Increment(move.pose.inverse())

    def bring(
        self, then: float, now: float, sightings: tuple[Sighting, ...], ends: Array
    ) -> tuple[tuple[Sighting, ...], Array]:
        """Sightings and points (N, 2) [m] in the robot frame of `then` → in that of `now`."""
        move = self.moved(then, now)
        if move is None or move.pose == Pose():
            return sightings, ends
        return tuple(carried(sighting, move, now) for sighting in sightings), move.pose.inverse().apply(ends)


def _part(move: Increment, first: float, last: float) -> Increment:
    if (first, last) == (0.0, 1.0):
        return move
    pose = _share(move.pose, first).inverse() @ _share(move.pose, last)
    return Increment(pose, (last - first) * move.covariance)


def _share(pose: Pose, share: float) -> Pose:
    chord = share * np.sinc(0.5 * share * pose.heading / np.pi) / np.sinc(0.5 * pose.heading / np.pi)
    ahead = rotation(-0.5 * pose.heading * (1.0 - share)) @ (chord * pose.x, chord * pose.y)
    return Pose(float(ahead[0]), float(ahead[1]), share * pose.heading)


def carried(sighting: Sighting, move: Increment, stamp: float) -> Sighting:
    """A sighting from before a move that ended at `stamp` [s] → as it would have looked after it.

    The move's doubt adds to its covariance.
    """
    back = move.pose.inverse()
    x, y = back.apply(sighting.position[None])[0].tolist()
    reach = max(float(np.hypot(x, y)), 1e-6)
    turned = rotation(back.heading)
    bearing = float(np.arctan2(y, x))
    slope = np.array([[x / reach, y / reach], [-y / reach**2, x / reach**2]])
    by_sighting = slope @ turned @ _outward(sighting)
    by_move = slope @ np.column_stack((-turned, (y, -x)))
    noise = by_sighting @ sighting.covariance @ by_sighting.T + by_move @ move.covariance @ by_move.T
    opening = None if sighting.opening is None else wrap(sighting.opening - move.pose.heading)
    return replace(sighting, stamp=stamp, range=reach, bearing=bearing, covariance=noise, opening=opening)


def _outward(sighting: Sighting) -> Array:
    """(2, 2): change of a sighting's place with its range and bearing."""
    c, s = np.cos(sighting.bearing), np.sin(sighting.bearing)
    return np.array([[c, -sighting.range * s], [s, sighting.range * c]])
