"""Two publishers of one topic: their readings take turns (A-B-A-B), which those of one sensor never do.

Where two robots share a wire under the same names, each reading is sound by itself, and timely. What tells is that
one comes back to what was read before the last one, again and again: however a robot moves, what it senses is more
like the reading before than like an older one. Any run of up to three readings of one publisher counts as a turn.
"""

import math
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from core.geometry import Pose, wrap
from core.message import Array
from core.sensors.laser import Scan
from core.sensors.wheels import Wheels

ReadingT = TypeVar("ReadingT")

MAX_RUN_READINGS = 3  # of one publisher in a row, until the other's turn
MAX_TURN_S = 1.0  # from a publisher's reading to its next one after the other's turn
WATCHED_READINGS = 40  # the newest, among which some come back to older ones
MIN_RETURNS = 3  # of them, that come back to an older one
MAX_RETURN_RATIO = 0.5  # of the difference to the older one and that to the last one
SECTOR_RAD = math.radians(3.0)  # one range each
SECTORS = round(math.tau / SECTOR_RAD)
FAR_M = 8.0  # from which on a range is as good as nothing there
MOVED_M, MOVED_RATIO = 0.1, 0.05  # and of the range: by which a sector's range differs
MOVED_SECTORS_SHARE = 0.1  # of the sectors that both scans read, from which on they are of two places
MIN_COMPARED_SECTORS = 12
APART_M, APART_RAD = 0.1, 0.1  # from which on two readings of odometry are of two places
MIN_PLACE_RETURNS_SHARE = 0.2  # of the places of a log: those by satellite jump about, and come back by chance
MAX_SAMPLED_BLOCKS = 40  # of a log, by which it is judged


@dataclass(frozen=True)
class WatchedReading(Generic[ReadingT]):
    """A reading, when it was taken or came [s], and its publisher; "": the wire does not tell."""

    reading: ReadingT
    time: float
    source: str = ""


class PublisherWatch(Generic[ReadingT]):
    """Judges the readings of one topic in the order in which they come."""

    def __init__(self, difference: Callable[[ReadingT, ReadingT], float]) -> None:
        """`difference` of two readings: from 1 on they cannot be of one place; what is in doubt is 0."""
        self._difference = difference
        self._recent: deque[WatchedReading[ReadingT]] = deque(maxlen=MAX_RUN_READINGS + 1)
        self._runs: deque[WatchedReading[ReadingT]] = deque(maxlen=2)  # the newest of either publisher
        self._returned: deque[bool] = deque(maxlen=WATCHED_READINGS)

    def take(self, reading: ReadingT, time: float, source: str = "") -> bool:
        """One reading → whether two publishers take turns."""
        new = WatchedReading(reading, time, source)
        self._returned.append(self._comes_back(new))
        self._recent.append(new)
        return sum(self._returned) >= MIN_RETURNS

    @property
    def returns_share(self) -> float:
        """Of the newest readings, those that come back to an older one."""
        return sum(self._returned) / max(1, len(self._returned))

    def _comes_back(self, new: WatchedReading[ReadingT]) -> bool:
        """Return whether a reading is like an older one, and between is a run that is unlike both.

        The run is alike in itself, and like a run before it: a robot that turns to and fro comes back, too, but from
        another place each time.
        """
        recent = list(self._recent)
        if not recent or self._apart(new, recent[-1]) < 1.0:
            return False
        for number in range(len(recent) - 2, -1, -1):
            one, run = recent[number], recent[number + 1 :]
            turn = min(self._apart(new, run[-1]), self._apart(one, run[0]))
            if turn < 1.0 or abs(new.time - one.time) > MAX_TURN_S:
                continue
            if max(self._apart(new, one), *(self._apart(run[0], other) for other in run)) <= MAX_RETURN_RATIO * turn:
                known = any(self._apart(run[0], other) <= MAX_RETURN_RATIO * turn for other in self._runs)
                self._runs.append(run[0])
                return known
        return False

    def _apart(self, one: WatchedReading[ReadingT], other: WatchedReading[ReadingT]) -> float:
        return math.inf if one.source != other.source else self._difference(one.reading, other.reading)


def scan_watch() -> PublisherWatch[Array]:
    """Make a watch over the scans of one laser, each as its `sector_ranges`."""
    return PublisherWatch(_views_apart)


def odometry_watch() -> PublisherWatch[Pose]:
    """Make a watch over the odometry of one base, as it was read."""
    return PublisherWatch(_places_apart)


def sector_ranges(scan: Scan, heading: float = 0.0) -> Array:
    """A scan, and the robot's heading [rad] → the nearest range in every sector of 3° (120,) [m]; NaN: none measured.

    So scans of a robot that turns, or of a laser whose number of beams varies, can be compared. Drivers send a scan
    that hit nothing now and then; it measured none.
    """
    sectors = np.floor((scan.angles + heading) / SECTOR_RAD).astype(int) % SECTORS
    nearest = np.full(SECTORS, np.nan)
    np.fmin.at(
        nearest, sectors, np.where(scan.valid | (np.isposinf(scan.ranges) & scan.valid.any()), scan.ranges, np.nan)
    )
    return np.minimum(nearest, FAR_M)


def scan_turns(scans: Sequence[Scan], wheels_at: Callable[[float], Wheels] | None) -> float:
    """The scans of one laser of a log, in time order → the share of it in which two publishers take turns.

    `wheels_at` a time [s]; None: there is no odometry.
    """

    def seen(number: int) -> tuple[Array, float]:
        scan = scans[number]
        heading = 0.0 if wheels_at is None else wheels_at(scan.stamp).odometry.heading
        return sector_ranges(scan, heading), scan.stamp

    return _turns(len(scans), scan_watch, seen)


def odometry_turns(times: Array, poses: Array) -> float:
    """Odometry of a log, times (N,) [s] and poses (N, 3) → the share of it in which two publishers take turns."""

    def read(number: int) -> tuple[Pose, float]:
        return Pose(*map(float, poses[number])), float(times[number])

    return _turns(len(times), odometry_watch, read, MIN_PLACE_RETURNS_SHARE)


def _turns(
    count: int,
    make: Callable[[], PublisherWatch[ReadingT]],
    reading: Callable[[int], tuple[ReadingT, float]],
    least: float = 0.0,
) -> float:
    """Judge blocks of the readings, spread over the log: it may have a million."""
    blocks = max(1, min(MAX_SAMPLED_BLOCKS, count // WATCHED_READINGS))
    mixed = 0
    for start in np.linspace(0, max(0, count - WATCHED_READINGS), blocks).astype(int).tolist():
        watch = make()
        judged = [watch.take(*reading(number)) for number in range(start, min(start + WATCHED_READINGS, count))]
        mixed += any(judged) and watch.returns_share >= least
    return mixed / blocks


def _views_apart(one: Array, other: Array) -> float:
    read = np.isfinite(one) & np.isfinite(other)
    count = int(np.count_nonzero(read))
    if count < MIN_COMPARED_SECTORS:
        return 0.0
    one, other = one[read], other[read]
    moved = np.abs(one - other) > MOVED_M + MOVED_RATIO * np.minimum(one, other)
    return float(np.count_nonzero(moved)) / (MOVED_SECTORS_SHARE * count)


def _places_apart(one: Pose, other: Pose) -> float:
    turned = abs(wrap(one.heading - other.heading))
    return max(one.distance_to(other.x, other.y) / APART_M, turned / APART_RAD)
