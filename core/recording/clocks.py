"""Times of a recording: which clock each reading was stamped by, and one clock for all of them.

A record carries the stamp of its device and, mostly, the time at which the recorder had it. The device's is the
better one as long as it can be true: devices with clocks of their own, clocks that are set while a recording runs
and stamps without a value are found by comparing both.
"""

import itertools
from dataclasses import dataclass

import numpy as np

from core.message import Array
from core.recording.read_report import ReadReport
from core.sensors.laser import MAX_STAMP_S

MAX_BACKWARD_S = 1.0  # by which the recorder's time may go back within a file: writers buffer
MAX_PAUSE_S = 600.0  # of a recording that was paused; after more its clock was set
MAX_CLOCK_DIFFERENCE_S = 1.0  # between the clocks of two devices
MAX_LATENCY_SPREAD_S = 0.5  # (median deviation) of the way to a recorder whose times can be compared
MAX_OUTLIER_S = 30.0  # of a single stamp from what the others suggest
OUTLIER_WINDOW_ROWS = 51  # that suggest it: over a whole recording a clock may run slower, as a simulator's does
MIN_JUMP_S = 1.0  # of a device's clock that was set, beyond the time that passed for the recorder
MIN_JUDGED_ROWS = 20  # of a stream whose clock is judged
MAX_RATE = 30.0  # times the recorder's, at which a simulator's clock may run
MAX_BACKWARD_SHARE = 0.05  # of the stamps that are older than the one before
MIN_DRIFT_S = 0.3  # by which two clocks run apart over a log
MAX_REPEATED = 3  # stamps that repeat the one before in a short log
MAX_REPEATED_SHARE = 0.1  # of stamps that repeat the one before: beyond it they are rounded or have no value
MIN_BACK_S = 1.0  # by which the stamps of a file that begins again go back
MAX_PARTS = 8  # of a file; what goes back more often is in no order
MIN_OVERLAP = 0.2  # of the shorter part, in which the longer one has stamps, too
MIN_PART_ROWS = 10
MAX_PERIOD_S, MIN_PERIOD_S = 20.0, 0.001  # between scans; what lies outside is in another unit
MAX_ODOMETRY_PERIOD_S = 1.0
PARTS_OF_SECOND = {1e-3: "milliseconds", 1e-6: "microseconds", 1e-9: "nanoseconds", 1e3: "kiloseconds"}
COUNTER_SPANS = (
    2**16,
    2**24,
    2**31,
    2**32,
    *(days * 86400 * unit for days in (1, 7) for unit in (1, 10**3, 10**6, 10**9)),
)
MAX_COUNTER_GAP = 10.0  # periods between the last reading before a counter is full and the first after it
DEFAULT_PERIOD_S = 0.1  # between scans that carry no times at all
DEFAULT_SPEED_M_S, MAX_WAY_M = 0.5, 3.0  # at which their odometry drives then; and at most from scan to scan


class RecorderClock:
    """The recorder's time, message by message in the order of the file: a clock that was set leaves no gap.

    A jump is one of every topic: files may hold one topic after the other, each from the beginning.
    """

    def __init__(self) -> None:
        self._newest: float | None = None  # [s] of the message before, of any topic
        self._seen: dict[str, tuple[float, int]] = {}  # topic → time of its newest message [s], jumps until then
        self._shift_s = 0.0
        self._messages = 0
        self.jumps_s: list[float] = []  # by which it was set

    @property
    def is_unordered(self) -> bool:
        """True where the messages lie in no order, so that nothing can be known of the clock."""
        return len(self.jumps_s) > max(MAX_PARTS, MAX_BACKWARD_SHARE * self._messages)

    def begin_file(self) -> None:
        """Begin with another file, whose times may lie before those of the last one."""
        self._newest, self._shift_s = None, 0.0
        self._seen.clear()

    def corrected(self, topic: str, logged: float) -> float:
        """Return the time [s] of the next message as if the clock had never been set."""
        self._messages += 1
        last, jumps = self._seen.get(topic, (logged, 0))
        before = logged if self._newest is None else self._newest
        jumped = not any(-MAX_BACKWARD_S <= logged - one <= MAX_PAUSE_S for one in (last, before))
        if self._newest is not None and jumps == len(self.jumps_s) and jumped:
            self.jumps_s.append(logged - self._newest)
            self._shift_s -= logged - self._newest
        self._newest = logged
        self._seen[topic] = logged, len(self.jumps_s)
        return logged + self._shift_s


@dataclass
class StampedStream:
    """The times of one topic's records, in the order of the file."""

    name: str
    own: Array  # (N,) [s] stamps in the records; NaN or 0 where they carry none
    logged: Array  # (N,) [s] by the recorder

    @property
    def latency(self) -> float:
        """Time [s] from the stamp to the recorder, the median; minus the difference of their clocks."""
        return float(np.median(self.logged - self.own))

    @property
    def drift(self) -> float:
        """By how much the latency [s] grew from the first tenth of the readings to the last one."""
        late, tenth = self.logged - self.own, max(1, len(self.own) // 10)
        return float((np.median(late[-tenth:]) - np.median(late[:tenth])) / 0.9)

    @property
    def comparable(self) -> bool:
        """True where the way to the recorder takes about the same time always."""
        late = self.logged - self.own
        return bool(np.median(np.abs(late - np.median(late))) < MAX_LATENCY_SPREAD_S)


def settled_stamps(stream: StampedStream, report: ReadReport) -> tuple[StampedStream, Array]:
    """Find the stamps to use of one topic → the stream with them as its own, and which are good (N,) bool.

    The records' own are used unless most are missing (NaN, zero) or repeat; where their clock was set, they go on as
    the recorder's time did.
    """
    from scipy.ndimage import median_filter  # late: drivers do without scipy

    own, logged = stream.own, stream.logged
    stamped = np.isfinite(own) & (own > 0)
    if not stamped.any() or len(np.unique(own[stamped])) * 2 < len(own):
        return StampedStream(stream.name, logged.copy(), logged), np.isfinite(logged)
    if fault := _untrue(own[stamped], logged[stamped]):
        report.fault(fault[0], stream.name, used=True, times=fault[1])
        return StampedStream(stream.name, logged.copy(), logged), np.isfinite(logged)
    own = own.copy()
    rows = np.flatnonzero(stamped)
    passed, stepped = np.diff(logged[rows]), np.diff(own[rows])
    jumped = (np.abs(stepped - passed) > MIN_JUMP_S) & (np.abs(passed) < MIN_JUMP_S)
    jumped &= ~_comes_back(stepped - passed)
    if jumped.any():
        own[rows[1:]] -= np.cumsum(np.where(jumped, stepped - passed, 0.0))
        largest = float(stepped[jumped][np.argmax(np.abs(stepped[jumped]))])
        report.fault("clock.set", stream.name, used=True, jump=f"{largest:+.0f}")
    late = (own - logged)[rows]
    good = np.zeros(len(own), bool)
    good[rows] = np.abs(late - median_filter(late, OUTLIER_WINDOW_ROWS, mode="nearest")) < MAX_OUTLIER_S
    return StampedStream(stream.name, own, logged), good


def _untrue(own: Array, logged: Array) -> tuple[str, str] | None:
    """Stamps (N,) [s] and the recorder's times of the same → why they cannot be true, and how fast they run."""
    passed = float(np.ptp(logged))
    if len(own) < MIN_JUDGED_ROWS or not passed > 0:
        return None
    steps = np.diff(own[np.argsort(logged, kind="stable")])
    backward = (steps < 0) & (steps > -MIN_JUMP_S)
    if np.mean(backward) > MAX_BACKWARD_SHARE and np.count_nonzero(backward) > MAX_REPEATED:
        return "clock.backward", ""
    rate = abs(float(np.median(steps[steps != 0]))) * (len(own) - 1) / passed if np.any(steps) else 1.0
    rates = rate, float(np.ptp(own)) / passed  # a pause spoils the one, a wrong stamp the other
    return None if any(1 / MAX_RATE < one < MAX_RATE for one in rates) else ("clock.rate", f"{rate:.3g}")


def at_one_rate(laser: StampedStream, wheels: StampedStream, report: ReadReport) -> None:
    """Give the stream whose clock runs faster or slower than the other's the recorder's times, in place."""
    if min(len(laser.own), len(wheels.own)) < MIN_JUDGED_ROWS or not (laser.comparable and wheels.comparable):
        return
    drifts = laser.drift, wheels.drift
    if abs(drifts[0] - drifts[1]) < MIN_DRIFT_S:
        return
    moved = laser if abs(drifts[0]) > abs(drifts[1]) else wheels
    passed = float(np.ptp(moved.logged))
    report.fault("clock.rate", moved.name, used=True, times=f"{1 - moved.drift / passed:.3g}")
    moved.own[:] = moved.logged


def _comes_back(steps: Array) -> Array:
    """Return which of the steps (N,) [s] of a clock a neighbour takes back: a single wrong stamp, no clock."""
    after = np.append(np.abs(steps[:-1] + steps[1:]) < MIN_JUMP_S, False)
    return after | np.append(False, after[:-1])


def on_one_clock(laser: StampedStream, wheels: StampedStream, report: ReadReport) -> tuple[float, float]:
    """Return the times [s] to add to the stamps of the laser and to those of the odometry, so that both fit.

    Where their devices' clocks differ, the times at which the recorder had them are what they have in common; the one
    that is nearer to the recorder's stays.
    """
    if not len(laser.own) or not len(wheels.own):
        return 0.0, 0.0
    at_one_rate(laser, wheels, report)
    apart = laser.latency - wheels.latency
    if abs(apart) <= MAX_CLOCK_DIFFERENCE_S or not (laser.comparable and wheels.comparable):
        return 0.0, 0.0
    moved, other = (wheels, laser) if abs(laser.latency) < abs(wheels.latency) else (laser, wheels)
    difference = _spoken(other.latency - moved.latency)
    report.fault("clock.differs", moved.name, used=True, difference=difference, other=other.name)
    return (apart, 0.0) if moved is laser else (0.0, -apart)


def _spoken(seconds: float) -> str:
    """A difference of clocks for people: "4.0 s behind"."""
    size = abs(seconds)
    words = f"{size:.1f} s" if size < 600 else f"{size / 3600:.1f} h" if size < 2e5 else f"{size / 86400:.0f} days"
    return f"{words} {'ahead of' if seconds > 0 else 'behind'}"


def evenly_spread(stamps: Array, report: ReadReport, sensor: str, places: Array | None = None) -> Array:
    """Stamps (N,) [s] in the order of the file → the same, and those that repeat spread over the time to the next.

    A few that repeat stay: they are readings that were written twice. Where all are the same, or rounded to more than
    a pause, the readings are taken at 10 a second, or as fast as a robot drives: `places` (N, 2) [m] by its odometry.
    """
    rows = len(stamps)
    if rows < 2 or not np.isfinite(stamps).all():
        return stamps
    repeats = np.diff(stamps) == 0
    if np.count_nonzero(repeats) <= max(MAX_REPEATED, MAX_REPEATED_SHARE * (rows - 1)):
        return stamps
    firsts = np.flatnonzero(np.append(True, ~repeats))
    apart = np.abs(np.diff(stamps[firsts]))
    if len(firsts) < 2 or np.median(apart) > MAX_PAUSE_S or apart.sum() > MAX_PERIOD_S * rows:
        period = _driven_period(places)
        report.fault("clock.none", sensor, used=True, rate=f"{1 / period:.2g}")
        return period * np.arange(rows)
    report.fault("clock.rounded", sensor, used=True, share=f"{100 * np.mean(repeats):.0f}")
    lengths = np.diff(np.append(firsts, rows))
    whole = np.arange(len(firsts)) > 0  # the first run may have begun before the file did
    period = np.median(np.diff(stamps[firsts])[whole[:-1]] / lengths[:-1][whole[:-1]]) if len(firsts) > 2 else None
    spread = stamps.astype(float).copy()
    for index, (first, length) in enumerate(zip(firsts, lengths, strict=True)):
        last = index == len(firsts) - 1
        span = stamps[firsts[index + 1]] - stamps[first] if not last else (period or DEFAULT_PERIOD_S) * length
        if index == 0 and period is not None and not last:
            spread[:length] = stamps[firsts[1]] - period * np.arange(length, 0, -1)
        else:
            spread[first : first + length] = stamps[first] + span * np.arange(length) / length
    return spread


def _driven_period(places: Array | None) -> float:
    """The time [s] between scans without times, by which their odometry drives from place to place (N, 2) [m]."""
    if places is None or np.isfinite(places).all(axis=1).sum() < 2:
        return DEFAULT_PERIOD_S
    way = float(np.nanquantile(np.hypot(*np.diff(places, axis=0).T), 0.9))
    return max(DEFAULT_PERIOD_S, way / DEFAULT_SPEED_M_S) if way < MAX_WAY_M else DEFAULT_PERIOD_S


def unwrapped(stamps: Array, sensor: str, report: ReadReport) -> Array:
    """Times (N,) of a text log in the order of the file, in any unit → the same; a full counter goes on.

    A counter of 16, 24, 31 or 32 bits, a time of day or of the week begins again at zero, or at minus its half.
    """
    steps = np.diff(stamps)
    if np.count_nonzero(steps > 0) < MIN_PART_ROWS:
        return stamps
    near = MAX_COUNTER_GAP * float(np.median(steps[steps > 0]))
    full = np.zeros(len(steps))
    for span in COUNTER_SPANS:
        began = [(first <= stamps[1:]) & (stamps[1:] < first + near) for first in (0, -span / 2)]
        full[(steps < 0) & (steps + span >= 0) & (steps + span < near) & (began[0] | began[1])] = span
    if not full.any():
        return stamps
    report.fault("clock.counter", sensor, used=True, span=f"{full.max():.0f}")
    return stamps + np.append(0.0, np.cumsum(full))


def seconds_per_unit(stamps: Array, sensor: str, report: ReadReport) -> float:
    """Stamps (N,) of a text log, of which nothing says their unit → [s] of one, by the time between two scans."""
    steps = np.diff(stamps[np.isfinite(stamps)])
    period = float(np.median(steps[steps > 0])) if np.count_nonzero(steps > 0) >= MIN_PART_ROWS else 1.0
    newest = float(np.nanmax(np.abs(stamps), initial=0.0))

    def fits(unit: float) -> bool:
        return MIN_PERIOD_S <= unit * period <= MAX_PERIOD_S and unit * newest <= MAX_STAMP_S

    unit = next((one for one in (1.0, *PARTS_OF_SECOND) if fits(one)), 1.0)
    if unit != 1.0:
        report.fault("clock.unit", sensor, used=True, period=f"{period:.3g}", unit=PARTS_OF_SECOND[unit])
    return unit


def in_seconds(laser: StampedStream, wheels: Array, report: ReadReport) -> None:
    """Bring times to seconds, in place, where all clocks of a recording count in another unit.

    `wheels`: the odometry's stamps and the recorder's times of it (M, 2). Scans alone may be sparse.
    """
    steps = np.abs(np.diff(wheels[:, 0]))
    period = float(np.median(steps[steps > 0])) if np.any(steps > 0) else 0.0
    rate = float(np.ptp(laser.own) / max(np.ptp(laser.logged), 1e-9))
    if not 0.5 < rate < 2.0 or MIN_PERIOD_S < period < MAX_ODOMETRY_PERIOD_S:
        return
    begun, unit = laser.own[0], seconds_per_unit(laser.own - laser.own[0], laser.name, report)
    for times in (laser.own, laser.logged, wheels):
        times[:] = begun + unit * (times - begun)


def longest_part(stamps: Array) -> tuple[int, int]:
    """Stamps (N,) [s] in the order of the file → first and last row + 1 of its longest part.

    That is the whole file, unless its times begin again within those that were before: two recordings in one file.
    """
    edges = [0, *(np.flatnonzero(np.diff(stamps) < -MIN_BACK_S) + 1).tolist(), len(stamps)]
    parts = [(a, b) for a, b in itertools.pairwise(edges) if b - a >= MIN_PART_ROWS]
    if not 2 <= len(parts) <= MAX_PARTS or len(edges) > MAX_PARTS + 1:
        return 0, len(stamps)
    first, last = max(parts, key=lambda part: part[1] - part[0])
    low, high = stamps[first:last].min(), stamps[first:last].max()

    def overlaps(part: tuple[int, int]) -> bool:
        times = stamps[part[0] : part[1]]
        return bool(np.mean((times >= low) & (times <= high)) > MIN_OVERLAP)

    again = any(overlaps(part) for part in parts if part != (first, last))
    return (first, last) if again else (0, len(stamps))
