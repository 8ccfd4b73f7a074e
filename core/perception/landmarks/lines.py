"""Straight lines in a sweep of laser points: break, split, merge, fit."""

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from core.message import Array
from core.setting import Meta, Section

MIN_LENGTH_M = 1e-12


@dataclass(frozen=True)
class LineSettings(Section):
    """Criteria that separate lines from noise.

    Watch:
        noise_floor: lines in the scene; raise it for walls in pieces near the robot
        noise_ratio: lines in the scene; raise it for walls in pieces far away
        points: corners in the scene; lower it where a coarse laser finds too few
        length: corners in the scene; raise it for legs and chairs among them
    """

    beam_sd: float = 0.0005  # [rad] sd of a beam's direction
    slant: float = math.radians(10)  # [rad] angle below which a wall breaks into points
    missing: int = 4  # [beams] gap inside a line, at most
    jump: float = 3.0  # [sd] difference of two neighbouring ranges that breaks a line
    split: float = 3.0  # [sd] distance from the chord at which a line is split
    merge_rms: float = 1.15  # [sd] joint residual up to which neighbours are merged
    merge_max: float = 4.0  # [sd] worst residual up to which they are merged
    fit: float = 1.3  # [sd] residual of a wall's final fit, at most, beyond what few samples excuse
    noise_floor: Annotated[float, Meta("m", 1e-4, 0.2, "least sd of a range")] = 0.01
    noise_ratio: Annotated[float, Meta("", 0, 0.2, "sd of a range as a share of it: 1 % for the URG-04LX")] = 0.01
    points: Annotated[int, Meta("", 3, 200, "points of a line, at least")] = 6
    length: Annotated[float, Meta("m", 0.02, 5, "length of a line, at least")] = 0.25


@dataclass(frozen=True, slots=True)
class Line:
    """A fitted line. Samples `first` to `last`, both included."""

    first: int
    last: int
    x: float  # [m] centroid
    y: float
    ux: float  # unit direction, from the first sample to the last
    uy: float
    begin: float  # [m] along the line from the centroid to the first sample
    end: float  # [m] to the last


class Sweep:
    """Laser points (M, 2) [m] seen from the origin, in the order of their beams (M,), `step` [rad] apart."""

    def __init__(self, points: Array, beams: Array, step: float, settings: LineSettings) -> None:
        self.points = points
        self.beams = beams
        self.step = abs(step)
        self.settings = settings
        self.ranges = np.maximum(np.hypot(points[:, 0], points[:, 1]), MIN_LENGTH_M)
        self.directions = points / self.ranges[:, None]
        self.sd = self._range_sd(self.ranges)
        x, y = points.T
        columns = (np.ones_like(x), x, y, x * x, x * y, y * y, self.sd**2)
        self._sums = np.zeros((len(x) + 1, len(columns)))  # running sums: any stretch is then fitted at one cost
        np.cumsum(np.column_stack(columns), axis=0, out=self._sums[1:])

    def clusters(self) -> list[tuple[int, int]]:
        """Stretches between jumps (adaptive break points) and gaps, as (first, last) samples."""
        if len(self.points) < 2:
            return []
        gap = np.diff(self.beams)
        angle = np.minimum(gap * self.step, 0.9 * self.settings.slant)
        near = np.minimum(self.ranges[1:], self.ranges[:-1])
        noise = self.settings.jump * np.hypot(self.sd[1:], self.sd[:-1])
        reach = near * np.sin(angle) / np.sin(self.settings.slant - angle) + noise
        step = np.diff(self.points, axis=0)
        broken = (np.hypot(step[:, 0], step[:, 1]) > reach) | (gap > self.settings.missing + 1)
        ends = np.flatnonzero(broken)
        firsts = [0, *(ends + 1).tolist()]
        lasts = [*ends.tolist(), len(self.points) - 1]
        return [(a, b) for a, b in zip(firsts, lasts, strict=True) if b - a + 1 >= self.settings.points]

    def split(self, first: int, last: int) -> list[tuple[int, int]]:
        """A cluster → stretches whose samples lie within `split` sd of their chord (iterative end points)."""
        found: list[tuple[int, int]] = []
        waiting = [(first, last)]
        while waiting:
            a, b = waiting.pop()
            if b - a < 2:
                found.append((a, b))
                continue
            (x0, y0), (x1, y1) = self.points[a].tolist(), self.points[b].tolist()
            off = self._off(a + 1, b, x0, y0, x1 - x0, y1 - y0)
            worst = int(off.argmax())
            if off[worst] <= self.settings.split:
                found.append((a, b))
            else:
                waiting += [(a + 1 + worst, b), (a, a + 1 + worst)]
        return found

    def merge(self, stretches: list[tuple[int, int]]) -> list[tuple[int, int]]:
        """Neighbouring stretches of one cluster → the same with collinear neighbours joined."""
        merged: list[tuple[int, int]] = []
        for stretch in stretches:
            current = stretch
            while merged and self._is_straight(merged[-1][0], current[1]):
                current = (merged.pop()[0], current[1])
            merged.append(current)
        return merged

    def fit(self, first: int, last: int) -> Line | None:
        """Total least squares over samples `first` to `last`; None if they are too few or too short a line."""
        if last - first + 1 < self.settings.points:
            return None
        x, y, ux, uy, _ = self._axes(first, last)
        (x0, y0), (x1, y1) = self.points[first].tolist(), self.points[last].tolist()
        begin, end = (x0 - x) * ux + (y0 - y) * uy, (x1 - x) * ux + (y1 - y) * uy
        if begin > end:
            ux, uy, begin, end = -ux, -uy, -begin, -end
        return Line(first, last, x, y, ux, uy, begin, end) if end - begin >= self.settings.length else None

    def fit_ranges(self, first: int, last: int) -> tuple[Array, Array] | None:
        """Samples `first` to `last` → the line q·p = 1 they lie on, as q (2,) [1/m], and its covariance (2, 2).

        None if they are too few, or no line: a wall that hides a step gives the wrong corner with great certainty.

        Least squares on 1/range = q·direction. The laser errs along its beams and hardly across them: so the
        regressors are exact and, unlike with total least squares, noise neither tilts the line nor flatters it.
        """
        if last - first + 1 < self.settings.points:
            return None
        stretch = slice(first, last + 1)
        rough, _, _ = self._solve(stretch, self.ranges[stretch], np.zeros(last + 1 - first))
        directions = self.directions[stretch]
        ranges = 1.0 / np.maximum(directions @ rough, 1e-3)
        line, covariance, residual = self._solve(
            stretch, ranges, directions[:, 0] * rough[1] - directions[:, 1] * rough[0]
        )
        freedom = last - first - 1
        return (line, covariance) if residual < self.settings.fit**2 + 3 * math.sqrt(2 / freedom) else None

    def _solve(self, stretch: slice, ranges: Array, slope: Array) -> tuple[Array, Array, float]:
        """Weighted least squares, the weights by the expected ranges and the change of 1/range per radian.

        → the line, its covariance, and the mean squared residual in units of its variance.
        """
        sd = self._range_sd(ranges) / ranges**2
        directions, inverse = self.directions[stretch], 1.0 / self.ranges[stretch]
        weights = 1.0 / (sd**2 + (self.settings.beam_sd * slope) ** 2)
        weighted = directions * weights[:, None]
        covariance = np.linalg.inv(weighted.T @ directions)
        line = covariance @ (weighted.T @ inverse)
        residual = float((weights * (inverse - directions @ line) ** 2).sum()) / (len(inverse) - 2)
        return line, covariance, residual

    def _range_sd(self, ranges: Array) -> Array:
        return np.maximum(self.settings.noise_floor, self.settings.noise_ratio * ranges)

    def _is_straight(self, first: int, last: int) -> bool:
        if last - first < 2:
            return True
        x, y, ux, uy, residual = self._axes(first, last)
        if residual > self.settings.merge_rms**2:
            return False
        return float(self._off(first, last + 1, x, y, ux, uy).max()) < self.settings.merge_max

    def _off(self, first: int, stop: int, x: float, y: float, dx: float, dy: float) -> Array:
        """Distances of samples [first, stop) from a line through (x, y) along (dx, dy), in sd of a range."""
        points = self.points[first:stop]
        across = np.abs((points[:, 0] - x) * dy - (points[:, 1] - y) * dx)
        return across / (max(math.hypot(dx, dy), MIN_LENGTH_M) * self.sd[first:stop])

    def _axes(self, first: int, last: int) -> tuple[float, float, float, float, float]:
        """Samples `first` to `last` → centroid, direction, mean square off it over the range variance."""
        n, sx, sy, sxx, sxy, syy, noise = (self._sums[last + 1] - self._sums[first]).tolist()
        x, y = sx / n, sy / n
        cxx, cxy, cyy = sxx - n * x * x, sxy - n * x * y, syy - n * y * y
        angle = 0.5 * math.atan2(2 * cxy, cxx - cyy)
        ux, uy = math.cos(angle), math.sin(angle)
        along = cxx * ux * ux + 2 * cxy * ux * uy + cyy * uy * uy
        return x, y, ux, uy, max(cxx + cyy - along, 0.0) / noise


def find_lines(sweep: Sweep) -> list[Line]:
    """Points of a sweep → fitted lines in the order of the beams."""
    lines: list[Line] = []
    for first, last in sweep.clusters():
        for a, b in sweep.merge(sweep.split(first, last)):
            line = sweep.fit(a + (a != first), b - (b != last))
            if line is not None:
                lines.append(line)
    return lines
