"""The time offset between a laser and the odometry, from turns.

A scan that is stamped wrong by τ seems turned by τ times the turn rate. While the robot turns, the heading by scan
matching H(t) is therefore compared with the odometry's heading at another time, h(t + τ).
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import scipy

from core.geometry import Pose, wrap
from core.message import Array, message
from core.perception.landmarks.deskew import deskew
from core.sensors import Laser, Scan, Wheels
from core.setting import Meta, Section
from core.slam.scan_matching.field_matching import match_scan
from core.slam.scan_matching.likelihood_field import LikelihoodField

SEARCH_STEP_S = 0.01  # of the search
SLOPE_HALF_S = 0.01  # to either side over which the turn rate is measured
REFINEMENT_ROUNDS = 4  # of the refinement
UNKNOWN_HEADING_RAD = 0.5  # sd of the heading in which a turn begins
JITTER_SDS_S = (0.002, 0.005, 0.01, 0.02, 0.04)  # sd of a single stamp: the likeliest is taken
MAX_MISFIT = 4.0  # squared residual per degree of freedom, beyond which odometry and scans are not of one motion
MIN_RIVAL_EXCESS = 16.0  # by which the squared residual of any other minimum must be larger
MIN_TURN_SCANS = 6  # scans of a turn
MIN_SD_S = 0.001  # that is claimed at least: turns share the errors of the deskewing
CONTRADICTION_CHI2 = 25.0  # squared distance from which a turn contradicts those before: the laser's clock was set

MAX_TURN_SCANS = 64  # scans of a turn that the fit looks at
TURN_MARGIN_S = 0.5  # before and after a turn that belong to it
MAX_TURN_S = 12.0  # of one turn
TURN_WINDOW_S = 0.1  # over which it is seen whether the robot turns, and a scan's own motion at least
SAME_READING_S = 1e-6  # by which stamps of one reading differ
MAX_ODOMETRY_GAP_S = 0.15  # without odometry, over which the heading is not interpolated
SCAN_GAP_S = 0.5  # between scans of one turn, at most
ODOMETRY_MEMORY_S = 20.0  # of odometry
MAX_WAITING_SCANS = 64  # scans that may wait
PER_FRAME = 2  # scans that are matched in one frame, at most
MIN_POINTS = 20  # of a scan, at least
SEARCH_REACH_M, SEARCH_ANGLE_RAD = 0.1, math.radians(12)  # around the expected pose that are searched
MIN_SCORE = 0.4  # of a match, at least
BEAM_SHARE = 0.3  # of the angle between beams by which a heading by matching is uncertain too
VIEW_RIM_RAD = math.radians(3)  # at either end of the view of a scan that is matched on, where walls seem to end
KEYFRAME_WAY, KEYFRAME_TURN = 0.4, math.radians(40)  # [m], [rad] after which a scan is matched on another one


@dataclass(frozen=True)
class TimeOffsetSettings(Section):
    """Settings of the estimate of a laser's time offset.

    Watch:
        estimate: the laser's time offset in Connect
        largest: the laser's time offset in Connect; raise it where it lies at this bound
    """

    turning: float = 0.15  # [rad/s] turn rate from which a turn is looked at
    accepted_sd: float = 0.01  # [s] sd from which the offset is believed
    corrected: float = 0.01  # [s] offset from which stamps are corrected
    drift: float = 3e-05  # [s/s] sd of the drift between the clocks
    scan_sd: float = math.radians(0.1)  # [rad] sd of a heading by matching scans
    walk_sd: float = 0.005  # [rad/√rad] growth of the odometry's heading error in a turn
    scale_sd: float = 0.05  # sd of the odometry's scale of turns
    estimate: Annotated[bool, Meta(meaning="whether the offset is estimated and corrected", common=True)] = True
    largest: Annotated[float, Meta("s", 0.05, 0.5, "offset that is looked for, at most")] = 0.2


@message
class TimeOffset:
    """The time offset between a laser and the odometry."""

    laser: str  # name; "": the only one
    offset: float  # [s] to add to its stamps; positive: they are early
    sd: float  # [s]
    applied: float  # [s] that are added now


@dataclass(frozen=True)
class Estimated:
    """An offset and how sure it is."""

    offset: float  # [s]
    variance: float  # [s²]

    def fused(self, other: Estimated) -> Estimated:
        """Both together, as independent ones."""
        share = self.variance / (self.variance + other.variance)
        return Estimated(self.offset + share * (other.offset - self.offset), (1 - share) * self.variance)

    def contradicts(self, other: Estimated) -> bool:
        """Return whether chance does not explain the difference."""
        return (self.offset - other.offset) ** 2 > CONTRADICTION_CHI2 * (self.variance + other.variance)


class HeadingTrack:
    """The odometry's heading over time, without jumps at ±π."""

    def __init__(self) -> None:
        self._rows: deque[tuple[float, float, float]] = deque()  # stamp [s], heading [rad], speed [m/s]

    def add(self, stamp: float, wheels: Wheels) -> None:
        """Add the wheels of a frame at `stamp` [s] as they were read; no reading is added twice."""
        stamp, heading = stamp - wheels.age, wheels.as_read.heading
        if self._rows:
            last = self._rows[-1]
            if stamp <= last[0] + SAME_READING_S:
                return
            if stamp - last[0] > MAX_ODOMETRY_GAP_S:
                self._rows.clear()
            heading = last[1] + wrap(heading - last[1])
        self._rows.append((stamp, heading, wheels.speed))
        while self._rows[0][0] < stamp - ODOMETRY_MEMORY_S:
            self._rows.popleft()

    @property
    def oldest(self) -> float:
        """Stamp [s] from when on the heading is known without gaps."""
        return self._rows[0][0] if self._rows else math.inf

    @property
    def newest(self) -> float:
        """Stamp [s] of the newest heading."""
        return self._rows[-1][0] if self._rows else -math.inf

    @property
    def rate(self) -> float:
        """Turn rate [rad/s] at the end."""
        if not self._rows:
            return 0.0
        stamp, heading, _ = self._rows[-1]
        before = next((row for row in reversed(self._rows) if row[0] <= stamp - TURN_WINDOW_S), None)
        return 0.0 if before is None else (heading - before[1]) / (stamp - before[0])

    def columns(self, since: float) -> tuple[Array, Array]:
        """Stamps (K,) [s] and headings (K,) [rad] from `since` [s] on."""
        rows = np.array([row[:2] for row in self._rows if row[0] >= since]).reshape(-1, 2)
        return rows[:, 0], rows[:, 1]

    def turned(self, start: float, end: float) -> float:
        """The turn [rad] between two times [s]."""
        stamps, headings, _ = np.array(self._rows).T
        first, last = np.interp((start, end), stamps, headings).tolist()
        return last - first

    def wheels(self, at: float, duration: float) -> Wheels:
        """The wheels' mean twist over `duration` [s] around a time [s]."""
        stamps, _, speeds = np.array(self._rows).T
        half = max(duration, TURN_WINDOW_S) / 2
        at = min(at, self.newest - half)
        turn_rate = self.turned(at - half, at + half) / (2 * half)
        return Wheels(odometry=Pose(), speed=float(np.interp(at, stamps, speeds)), turn_rate=turn_rate)


def fit_time_offset(
    stamps: Array, headings: Array, track: tuple[Array, Array], settings: TimeOffsetSettings
) -> Estimated | None:
    """Headings (N,) [rad] by scans at `stamps` (N,) [s], and the odometry's → the offset; None where none fits.

    `track`: the odometry's stamps (K,) [s], which begin `largest` before the scans and end when the last one came,
    and its headings (K,) [rad]. Both headings run on without jumps, from any zero. Generalized least squares over τ
    in H(t) = c + (1 + s) h(t + τ): c is free, s has the sd `scale_sd`, the odometry's error grows with the turn, and
    every stamp jitters by the likeliest of JITTERS. No scan is from later than when it came, so that the odometry up
    to then suffices.
    """
    if len(stamps) < MIN_TURN_SCANS:
        return None
    found = _search(stamps, headings, track, settings)
    if found is None:
        return None
    offset, jitter = found
    whitener, _ = _whitener(stamps + offset, track, jitter, settings)
    misfit, information = 0.0, 0.0
    for _ in range(REFINEMENT_ROUNDS):
        times = stamps + offset
        slopes = scipy.linalg.solve_triangular(whitener, _rates(times, track), lower=True)
        left = scipy.linalg.solve_triangular(whitener, headings - np.interp(times, *track), lower=True)
        information = float(slopes @ slopes)
        if information <= 0.0:
            return None
        offset += float(slopes @ left) / information
        misfit = float(left @ left) / len(stamps)
    if misfit > MAX_MISFIT or abs(offset) > settings.largest:
        return None
    return Estimated(offset, max(misfit, 1.0) / information + MIN_SD_S**2)


def _search(
    stamps: Array, headings: Array, track: tuple[Array, Array], settings: TimeOffsetSettings
) -> tuple[float, float] | None:
    """The best offset [s] on a lattice of STEP, and the likeliest jitter [s]; None at the rim or near a rival."""
    count = round(settings.largest / SEARCH_STEP_S)
    offsets = SEARCH_STEP_S * np.arange(-count, count + 1)
    differences = headings[:, None] - np.interp(stamps[:, None] + offsets, *track)
    best, fits = 0.0, list[tuple[float, float, Array]]()
    for jitter in JITTER_SDS_S:
        whitener, log_volume = _whitener(stamps + best, track, jitter, settings)
        costs = (scipy.linalg.solve_triangular(whitener, differences, lower=True) ** 2).sum(axis=0)
        best = float(offsets[costs.argmin()])
        fits.append((float(costs.min()) + log_volume, jitter, costs))
    _, jitter, costs = min(fits, key=lambda fit: fit[0])
    at = int(costs.argmin())
    if not 0 < at < len(offsets) - 1 or _has_rival(costs, at):
        return None
    return float(offsets[at]), jitter


def _whitener(
    times: Array, track: tuple[Array, Array], jitter: float, settings: TimeOffsetSettings
) -> tuple[Array, float]:
    """Lower Cholesky factor (N, N) of the covariance of the heading differences at `times` (N,) [s]; its log det."""
    odometry = np.interp(times, *track)
    turned = np.concatenate(([0.0], np.cumsum(np.abs(np.diff(odometry)))))
    relative = odometry - odometry[0]
    covariance = settings.walk_sd**2 * np.minimum(turned[:, None], turned[None, :])
    covariance += settings.scale_sd**2 * np.outer(relative, relative) + UNKNOWN_HEADING_RAD**2
    covariance += np.diag(settings.scan_sd**2 + (jitter * _rates(times, track)) ** 2)
    factor = np.linalg.cholesky(covariance)
    return factor, 2.0 * float(np.log(np.diag(factor)).sum())


def _rates(times: Array, track: tuple[Array, Array]) -> Array:
    """The odometry's turn rates (N,) [rad/s] at times (N,) [s]."""
    return (np.interp(times + SLOPE_HALF_S, *track) - np.interp(times - SLOPE_HALF_S, *track)) / (2 * SLOPE_HALF_S)


def _has_rival(costs: Array, best: int) -> bool:
    inner = costs[1:-1]
    lowest = np.flatnonzero((inner <= costs[:-2]) & (inner <= costs[2:])) + 1
    others = costs[lowest[np.abs(lowest - best) > 1]]
    return bool(len(others)) and float(others.min()) < float(costs[best]) + MIN_RIVAL_EXCESS


class TurnMatcher:
    """The headings of successive scans by matching each on an earlier one.

    Of a laser that does not look all around only points within the earlier view count: beyond it that scan's walls
    seem to end, which draws the later one back by some tenths of a degree, as if it were stamped late.
    """

    def __init__(self, laser: Laser) -> None:
        self._laser = laser
        view = laser.angle_step * (laser.beams - 1)
        self._middle = laser.mounting.heading + laser.angle_min + 0.5 * view  # [rad] of the view
        self._half = 0.5 * view - VIEW_RIM_RAD if view < 2 * math.pi - 2 * VIEW_RIM_RAD else math.inf  # [rad]
        self._field: LikelihoodField | None = None
        self._base = Pose()  # of the scan that is matched on
        self._pose = Pose()  # of the newest scan
        self._heading = 0.0  # [rad] the same, running on without jumps

    def match(self, scan: Scan, at: float, wheels: Wheels, turn: float) -> float | None:
        """A scan, seen from time `at` [s], expected to be turned by `turn` [rad] from the one before → its heading.

        None where it fits nowhere: then the next one begins afresh.
        """
        points, _ = deskew(scan, self._laser, wheels, at)
        if len(points) < MIN_POINTS:
            self._field = None
            return None
        if self._field is None:
            self._base = self._pose = Pose(0.0, 0.0, wrap(self._heading))
            self._field = LikelihoodField(points)
            return self._heading
        guess = self._base.inverse() @ replace(self._pose, heading=wrap(self._pose.heading + turn))
        inside = points[self._in_view(guess.apply(points))]
        if len(inside) < MIN_POINTS:
            self._field = None
            return None
        match = match_scan(self._field, inside, guess, SEARCH_REACH_M, SEARCH_ANGLE_RAD)
        if match.score < MIN_SCORE:
            self._field = None
            return None
        self._pose = self._base @ match.pose
        self._heading += wrap(self._pose.heading - self._heading)
        if math.hypot(match.pose.x, match.pose.y) > KEYFRAME_WAY or abs(match.pose.heading) > KEYFRAME_TURN:
            self._base, self._field = self._pose, LikelihoodField(points)
        return self._heading

    def _in_view(self, points: Array) -> Array:
        """Points (N, 2) [m], seen from the scan that is matched on → (N,) whether its laser looked there."""
        bearings = np.arctan2(points[:, 1], points[:, 0]) - self._middle
        return np.abs(np.arctan2(np.sin(bearings), np.cos(bearings))) < self._half


class TimeOffsetEstimator:
    """Estimates a laser's time offset online. `update` with every frame; scans are matched only around turns.

    A turn is an estimate of its own; those that are over are fused, and their doubt grows with the clocks' drift.
    """

    def __init__(self, laser: Laser, settings: TimeOffsetSettings) -> None:
        scan_sd = math.hypot(settings.scan_sd, BEAM_SHARE * laser.angle_step)
        self._settings = replace(settings, scan_sd=scan_sd)
        self._laser = laser
        self._track = HeadingTrack()
        self._matcher = TurnMatcher(laser)
        self._waiting: deque[Scan] = deque(maxlen=MAX_WAITING_SCANS)
        self._turned = -math.inf  # [s] when the robot turned last
        self._turn: list[tuple[float, float]] = []  # stamp [s] and heading [rad] of the scans of the present turn
        self._present: Estimated | None = None  # by the present turn
        self._former: Estimated | None = None  # by the turns before it
        self._former_stamp = 0.0  # [s] of the last of them
        self.newest: Estimated | None = None  # by all turns; None: not known well enough

    def update(self, stamp: float, wheels: Wheels | None, scan: Scan | None) -> None:
        """Take the wheels at `stamp` [s], and a scan of this laser as it is stamped."""
        if wheels is not None:
            self._track.add(stamp, wheels)
        if abs(self._track.rate) > self._settings.turning:
            self._turned = stamp
        if scan is not None:
            self._waiting.append(scan)
        taken = False
        for _ in range(PER_FRAME):
            ready = self._next()
            taken = ready is not None or taken
            if ready is not None:
                self._match(ready)
        if taken:
            self._fit()

    def _next(self) -> Scan | None:
        """The next scan of a turn; the last ones wait at rest, as a turn may begin, and are dropped later."""
        around = self._settings.largest + TURN_MARGIN_S
        while self._waiting:
            middle = _middle(self._waiting[0])
            if middle < self._turned + around:
                return self._waiting.popleft()
            self._end_turn()
            if middle > self._track.newest - around:
                return None
            self._waiting.popleft()
        return None

    def _match(self, scan: Scan) -> None:
        """Find the scan's heading; where it fits nowhere, or the odometry has a gap, the turn begins again."""
        middle, offset = _middle(scan), self.newest.offset if self.newest else 0.0
        if self._turn and middle - self._turn[-1][0] > SCAN_GAP_S:
            self._turn.clear()
        earliest = middle - self._settings.largest
        if (
            earliest - TURN_WINDOW_S < self._track.oldest or earliest > self._track.newest
        ):  # the latter: the odometry stalls
            self._turn.clear()
            return
        turn = self._track.turned(self._turn[-1][0] + offset, middle + offset) if self._turn else 0.0
        duration = float(scan.times[-1] - scan.times[0])
        wheels = self._track.wheels(middle + offset, duration)
        heading = self._matcher.match(scan, middle, wheels, turn)
        if heading is None:
            self._turn.clear()
            return
        self._turn.append((middle, heading))

    def _fit(self) -> None:
        """Estimate the offset by the present turn, and by all."""
        if not self._turn:
            self._present = None
            return
        thinned = np.array(self._turn[:: -(-len(self._turn) // MAX_TURN_SCANS)])
        track = self._track.columns(self._turn[0][0] - self._settings.largest - TURN_WINDOW_S)
        self._present = fit_time_offset(thinned[:, 0], thinned[:, 1], track, self._settings)
        joined = self._joined()
        if joined is not None and joined.variance < self._settings.accepted_sd**2:
            self.newest = joined
        if self._turn[-1][0] - self._turn[0][0] > MAX_TURN_S:
            self._end_turn()

    def _end_turn(self) -> None:
        joined = self._joined()
        if self._turn and joined is not None:
            self._former, self._former_stamp = joined, self._turn[-1][0]
        self._turn.clear()
        self._present = None
        self._matcher = TurnMatcher(self._laser)

    def _joined(self) -> Estimated | None:
        """The present turn's estimate and those before; where they contradict each other, a sure present one."""
        present = self._present
        if self._former is None or not self._turn:
            return present
        drift = self._settings.drift * (self._turn[-1][0] - self._former_stamp)
        former = replace(self._former, variance=(math.sqrt(self._former.variance) + drift) ** 2)
        if present is None:
            return former
        if present.contradicts(former):
            return present if present.variance < self._settings.accepted_sd**2 else former
        return former.fused(present)


def _middle(scan: Scan) -> float:
    """The time [s] in the middle of a scan, at which its heading is nearly free of the motion meanwhile."""
    return scan.stamp + 0.5 * scan.time_step * (len(scan.ranges) - 1)
