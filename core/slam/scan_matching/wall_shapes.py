"""Shapes of walls in one laser's scans: where straight ones are bent alike, something is added to every range."""

import math

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from core.message import Array
from core.sensors import Fault, Laser, Scan
from core.sensors.checks import fault

WINDOWS_RAD = (math.radians(20), math.radians(36))  # of neighbouring beams that may show one wall
MIN_BEAMS = 12  # in such a window
MAX_LOOKS, MAX_WALLS = 80, 200  # scans that are looked at; walls after which it is known
MOVED_SHARE = 0.05  # of the ranges by which such scans differ
COMPARED_BEAMS = 40  # of a scan
MAX_TURN_RAD_S = 0.3  # beyond which a scan's own sweep bends walls, too
MIN_COSINE = 0.5  # between a wall's normal and the beams
MAX_GAP = 4.0  # usual distances between neighbouring points, from one to the next
NOISE_M, NOISE_SHARE, MAX_MISFIT = 0.01, 0.015, 1.5  # of a wall's points, and of their range; times that noise
MIN_SD_M, MAX_SD_SHARE = 0.02, 0.15  # of the offset by one wall, at least; at most, of its range
PART_COUNT, MAX_PART_SDS = 5, 2.5  # of a window, and how far off the mean of one may be
OFFSETS_M = np.arange(-1.0, 1.001, 0.02)  # that are tried
MIN_WALLS, MIN_OFFSET_M, MAX_ZERO_SHARE = 60, 0.17, 0.6  # walls; what is said; of the votes for it, those for none
MIN_BACKWARD_SHARE = 0.9  # of the walls that would lie behind the laser: their ranges are no distances


class WallShapes:
    """Looks at scans of a laser that moves, until enough of them were seen; `update` with every scan."""

    def __init__(self, laser: Laser) -> None:
        self._laser = laser
        self._last: Array | None = None  # (N,) ranges of the scan that was looked at last
        self._looks, self._walls, self._backward, self._straight = 0, 0, 0, 0
        self._votes = np.zeros(len(OFFSETS_M))

    def update(self, scan: Scan, turn_rate: float) -> None:
        """Look at a scan of a robot that turns at `turn_rate` [rad/s], unless it is much like the one before."""
        known = self._looks >= MAX_LOOKS or self._straight >= MAX_WALLS
        if known or self._is_old(scan):
            return
        self._last, self._looks = scan.ranges, self._looks + 1
        ranges = np.where(scan.valid, scan.ranges, np.nan).astype(float)
        for width in WINDOWS_RAD:
            offsets, sds, distances = bent_walls(ranges, scan.angle_step, width)
            self._walls += len(offsets)
            self._backward += int((distances < offsets).sum())
            if abs(turn_rate) > MAX_TURN_RAD_S:
                continue
            self._straight += len(offsets)
            self._votes += (1 / (1 + ((OFFSETS_M[:, None] - offsets) / sds) ** 2) / sds).sum(axis=1)

    def _is_old(self, scan: Scan) -> bool:
        return self._last is not None and median_change(scan.ranges, self._last) < MOVED_SHARE

    @property
    def faults(self) -> tuple[Fault, ...]:
        """Fault of the ranges, if there is one."""
        name = self._laser.name or "the laser"
        if self._walls < MIN_WALLS:
            return ()
        if self._backward > MIN_BACKWARD_SHARE * self._walls:
            return (fault("scan.no_distances", name),)
        best, none = int(self._votes.argmax()), len(OFFSETS_M) // 2
        offset = float(OFFSETS_M[best])
        if (
            self._straight < MIN_WALLS
            or abs(offset) < MIN_OFFSET_M
            or self._votes[none] > MAX_ZERO_SHARE * self._votes[best]
        ):
            return ()
        return (fault("scan.offset", name, used=True, offset=f"{offset:.1f}"),)


def median_change(now: Array, then: Array) -> float:
    """Ranges (N,) of two scans → the median of their change, as a share; infinite: they are not comparable."""
    if len(then) != len(now):
        return math.inf
    step = max(1, len(now) // COMPARED_BEAMS)
    now, then = now[::step], then[::step]
    seen = np.isfinite(now) & np.isfinite(then)
    return float(np.median(np.abs(now[seen] / then[seen] - 1.0))) if seen.any() else 0.0


def bent_walls(ranges: Array, step: float, width: float) -> tuple[Array, Array, Array]:
    """Ranges (N,) [m], NaN: none, the angle between beams and that of windows [rad] → for the walls in them (K,) what
    is to be taken off the ranges for them to be straight [m], its sd [m], and how far they are away as they are [m].

    A wall's distances from its own line are regressed on what an offset does to them, by least squares. Windows with
    an edge or a corner fit no wall even so, and are left out.
    """
    count = round(width / abs(step)) + 1
    if count < MIN_BEAMS or len(ranges) < count:
        return np.zeros(0), np.zeros(0), np.zeros(0)
    rows = sliding_window_view(ranges, count)[:: count // 4]
    rows = rows[np.isfinite(rows).all(axis=1)]
    angles = step * (np.arange(count) - 0.5 * (count - 1))
    x, y = rows * np.cos(angles), rows * np.sin(angles)
    dx, dy = x - x.mean(axis=1, keepdims=True), y - y.mean(axis=1, keepdims=True)
    normal = 0.5 * np.arctan2(2 * (dx * dy).sum(axis=1), (dx**2 - dy**2).sum(axis=1)) + 0.5 * math.pi
    c, s = np.cos(normal)[:, None], np.sin(normal)[:, None]
    away = x.mean(axis=1) * c[:, 0] + y.mean(axis=1) * s[:, 0]
    c, s, away = c * np.sign(away)[:, None], s * np.sign(away)[:, None], np.abs(away)
    off, along = c * dx + s * dy, c * dy - s * dx
    slope = c * np.cos(angles) + s * np.sin(angles)  # of the distances off the line, by the offset …
    slope = slope - slope.mean(axis=1, keepdims=True)
    slope = slope - along * ((slope * along).sum(axis=1) / (along**2).sum(axis=1))[:, None]  # … refitted
    information = (slope**2).sum(axis=1)
    offsets = (off * slope).sum(axis=1) / information
    rest = off - slope * offsets[:, None]
    misfit = np.sqrt((rest**2).sum(axis=1) / (count - 4))
    noise = 1.4826 / math.sqrt(6) * np.median(np.abs(np.diff(rest, 2, axis=1)), axis=1)
    gaps, middle, sds = np.abs(np.diff(along, axis=1)), rows.mean(axis=1), misfit / np.sqrt(information)
    kept = (away > MIN_COSINE * middle) & (gaps.max(axis=1) < MAX_GAP * np.median(gaps, axis=1))
    kept &= (noise < NOISE_M + NOISE_SHARE * middle) & (misfit < MAX_MISFIT * np.maximum(noise, 1e-3))
    kept &= sds < MAX_SD_SHARE * middle
    size = count // PART_COUNT
    parts = rest[:, : size * PART_COUNT].reshape(-1, PART_COUNT, size).mean(axis=2) * math.sqrt(size)
    kept &= np.abs(parts).max(axis=1) < MAX_PART_SDS * np.maximum(noise, 1e-3)
    return offsets[kept], np.maximum(sds[kept], MIN_SD_M), away[kept]
