"""Gatekeeper of scans, for live drivers and recordings alike: ranges and angles, checked with each other."""

import math
from dataclasses import replace
from typing import Protocol

import numpy as np

from core.message import Array
from core.sensors.checks import refusal
from core.sensors.laser import Scan

MAX_RANGE_MIN_M = 2.0  # from which the nearest range of a laser is no metres
MAX_MEDIAN_M = 100.0
MAX_MEDIAN_KM = 0.05  # below which a laser in metres would see nothing: its ranges are kilometres
MAX_RANGE_KM = 0.5  # of a laser in kilometres
MIN_MEDIAN_MM = 600.0  # between ranges in millimetres and in centimetres
MIN_JUDGED_BEAMS = 5  # that measured something
MIN_VALUE, MAX_VALUE, MAX_GARBAGE_SHARE = 1e-6, 1e8, 0.3  # of ranges in any unit; of those outside
MIN_WITHIN_SHARE = 0.5  # of the ranges within their limits: those of one place differ, marks of no return are equal
MIN_WHOLE_BEAMS, MIN_WHOLE_VALUES = 30, 4  # beams, different ranges, all whole: no metres
MIN_CONSTANT_BEAMS, CONSTANT_RATIO = 60, 0.02  # beams whose ranges differ by less of their median: no place is so
MIN_SPAN_DEG = 60.0  # of a scan in degrees
MIN_ANGLE_OFF_RAD = math.radians(5)  # by which the angles of a scan contradict each other


class FaultSink(Protocol):
    """Takes what a check found: the report of a log, the readings of a robot."""

    def fault(self, code: str, sensor: str = "", *, used: bool = False, **values: object) -> None:
        """Add a fault."""


class RangeUnit:
    """Units of a laser's ranges and of their limits, by the first scan that measured something."""

    def __init__(self, name: str, report: FaultSink) -> None:
        self.name, self.report = name, report
        self._unit: float | None = None  # metres per unit of the ranges
        self._limits: float | None = 1.0  # metres per unit of their limits; None: they cannot be

    def metres(self, ranges: Array, limits: tuple[float, float]) -> tuple[Array, tuple[float, float]]:
        """Ranges (N,) and (range_min, range_max) as they came → both in metres; limits that cannot be: 0 and NaN.

        Raises UnusableReading.
        """
        hits = ranges[np.isfinite(ranges) & (ranges > 0)]
        if self._unit is None and len(hits) >= MIN_JUDGED_BEAMS and _is_garbage(np.unique(hits)):
            raise refusal("scan.malformed", self.name, what="bytes of its ranges in another order")
        if self._unit is None and len(hits) >= MIN_JUDGED_BEAMS:
            self._judge(hits, *limits)
        elif len(hits) >= MIN_WHOLE_BEAMS and self._unit == 1.0 and _is_whole(hits):
            raise refusal("scan.whole_numbers", self.name)
        unit, scale = self._unit or 1.0, self._limits
        low, high = (0.0, math.nan) if scale is None else (limits[0] * scale, limits[1] * scale)
        return ranges if unit == 1.0 else ranges * np.float32(unit), (low, high)

    def of_scan(self, scan: Scan) -> Scan:
        """Return a driver's scan in metres, and say where its ranges cannot be. Raises UnusableReading."""
        ranges, (low, high) = self.metres(scan.ranges, (scan.range_min, scan.range_max))
        if is_constant(ranges):
            self.report.fault("scan.constant", self.name, used=True)
        if ranges is scan.ranges and low == scan.range_min:
            return scan
        high = high if high > low else float(np.nanmax(ranges, initial=low + 1.0, where=np.isfinite(ranges)))
        return replace(scan, ranges=ranges, range_min=low, range_max=high)

    def _judge(self, hits: Array, low: float, high: float) -> None:
        self._unit, unit = unit_of(hits, low)
        if unit == "metres" and _is_whole(hits):
            raise refusal("scan.whole_numbers", self.name)
        if unit != "metres":
            nearest, farthest = f"{hits.min():.4g}", f"{hits.max():.4g}"
            self.report.fault("scan.units", self.name, used=True, nearest=nearest, farthest=farthest, unit=unit)
        hits = hits * self._unit
        if len(np.unique(hits)) < 0.5 * len(hits):  # marks of nothing there, most of them
            self._limits = self._unit
            return

        def fits(scale: float) -> bool:
            within = (hits >= low * scale) & ((hits <= high * scale) | (not 0 < high < math.inf))
            return bool(np.mean(within) > MIN_WITHIN_SHARE)

        self._limits = next((scale for scale in (self._unit, 1.0, 0.001, 0.01, 1000.0) if fits(scale)), None)
        if self._limits != self._unit:
            limits = {"low": f"{low:.4g}", "high": f"{high:.4g}", "median": f"{np.median(hits):.3g}"}
            self.report.fault("scan.limits", self.name, used=True, **limits)


def unit_of(hits: Array, range_min: float) -> tuple[float, str]:
    """Ranges (N,) as logged and the nearest one that the laser measures → metres per unit, and the unit."""
    median = float(np.median(hits))
    if median < MAX_MEDIAN_KM and hits.max() < MAX_RANGE_KM:
        return 1000.0, "kilometres"
    kept = range_min > MAX_RANGE_MIN_M and np.mean(hits >= range_min) > 0.5
    if median <= (MAX_RANGE_MIN_M if kept else MAX_MEDIAN_M):
        return 1.0, "metres"
    return (0.001, "millimetres") if median > MIN_MEDIAN_MM else (0.01, "centimetres")


def _is_garbage(values: Array) -> bool:
    """Return whether many of the different ranges (N,) are as small or large as no unit makes them."""
    return bool(np.mean((values < MIN_VALUE) | (values > MAX_VALUE)) > MAX_GARBAGE_SHARE)


def _is_whole(hits: Array) -> bool:
    """Return whether ranges (N,) are whole numbers, as no laser measures metres."""
    if len(hits) < MIN_WHOLE_BEAMS or np.any(hits != np.rint(hits)):
        return False
    return len(np.unique(hits)) >= MIN_WHOLE_VALUES


def is_constant(ranges: Array) -> bool:
    """Return whether all beams of a scan (N,) [m] are as long, as if the laser stood in the middle of a drum."""
    hits = ranges[np.isfinite(ranges)]
    if len(hits) < max(MIN_CONSTANT_BEAMS, 0.5 * len(ranges)):
        return False
    least, middle, most = np.quantile(hits, (0.05, 0.5, 0.95))
    return bool(most - least < CONSTANT_RATIO * middle)


def checked_angles(
    name: str, beams: int, ends: tuple[float, float], step: float, report: FaultSink
) -> tuple[float, float]:
    """Beams of a scan, the angles of the first and the last one and the step between them → (angle_min, step) [rad].

    The step counts; where it cannot be, the angles of the ends do. Degrees are converted.
    """
    first, last = ends
    whole = math.tau + 0.1
    if beams < 2 or not math.isfinite(first) or not math.isfinite(step):
        return first, step
    if MIN_SPAN_DEG <= abs(step) * (beams - 1) <= 361.0 and abs(first) <= 361.0:
        report.fault("scan.degrees", name, used=True)
        return first if abs(first) <= whole else math.radians(first), math.radians(step)
    if not math.isfinite(last) or last in (0.0, first):
        if step == 0:
            return first, step
        last = first + step * (beams - 1)
    between = (last - first) / (beams - 1)
    if step == 0:
        report.fault("scan.step_zero", name, used=True)
        return first, between
    if abs(step - between) * (beams - 1) > max(2.5 * abs(step), 2.5 * abs(between), MIN_ANGLE_OFF_RAD):
        spans = {"by_step": f"{math.degrees(step) * (beams - 1):.0f}", "by_ends": f"{math.degrees(last - first):.0f}"}
        report.fault("scan.step_differs", name, used=True, **spans)
    return first, step
