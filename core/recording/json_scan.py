"""A scan written as JSON: a line of a text log, or a message of a JSON channel."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any, cast

import numpy as np

from core.message import Array
from core.recording.read_report import BadRecord
from core.recording.scans import make_scan, spread
from core.sensors import Scan

LONGEST = 4_000_000  # [bytes]


def read_json_scan(text: str | bytes, range_max: float) -> Scan | None:
    """One JSON object → its scan; None when it is an object without ranges. Raises BadRecord.

    Ranges in metres, null = no measurement. Angles by `angle_min` and `angle_increment` (or `angle_step`), or
    `start_angle` and `end_angle`; without them the beams are spread over 180°. Time `t`, `stamp`, `timestamp` or
    `header.stamp`; without one the stamp is NaN. `range_max` [m] of the settings, 0: as the scan says.
    """
    if len(text) > LONGEST:
        raise BadRecord("it is too long")
    try:
        record = json.loads(text)
    except (ValueError, RecursionError) as problem:
        raise BadRecord("it is no JSON, or cut" if text else "it is empty") from problem
    if not isinstance(record, dict):
        raise BadRecord("it is no JSON object")
    fields = cast("dict[str, Any]", record)
    if "ranges" not in fields:
        return None
    ranges = _ranges(fields["ranges"])
    high = range_max or _number(fields, "range_max", math.nan)
    low = _number(fields, "range_min", 0.0)
    limits = (low if math.isfinite(low) else 0.0, high if math.isfinite(high) else None)
    scan = make_scan(
        _stamp(fields), ranges, _angles(fields, len(ranges)), limits, _number(fields, "time_increment", 0.0)
    )
    if np.isnan(scan.ranges).all():
        raise BadRecord("none of its beams measured anything")
    return scan


def _ranges(value: Any) -> Array:
    """A JSON list of numbers and nulls → (N,) [m]."""
    if not isinstance(value, list):
        raise BadRecord("its ranges are no list")
    numbers = cast("list[Any]", value)
    if not all(
        number is None or (isinstance(number, int | float) and not isinstance(number, bool)) for number in numbers
    ):
        raise BadRecord("its ranges are no numbers")
    try:
        return np.array([math.nan if number is None else number for number in numbers], np.float64)
    except OverflowError as problem:
        raise BadRecord("its ranges are no numbers") from problem


def _angles(fields: Mapping[str, Any], beams: int) -> tuple[float, float]:
    """(angle_min, angle_step) [rad]."""
    if "angle_min" in fields:
        step = "angle_increment" if "angle_increment" in fields else "angle_step"
        return _number(fields, "angle_min", math.nan), _number(fields, step, math.nan)
    if "start_angle" in fields:
        start, end = _number(fields, "start_angle", math.nan), _number(fields, "end_angle", math.nan)
        return start, (end - start) / max(1, beams - 1)
    return spread(max(1, beams))


def _stamp(fields: Mapping[str, Any]) -> float:
    """Seconds, or NaN."""
    header = fields.get("header")
    for value in (*(fields.get(name) for name in ("t", "stamp", "timestamp")), cast("Any", header)):
        if isinstance(value, dict):
            parts = cast("dict[str, Any]", value)
            parts = parts["stamp"] if isinstance(parts.get("stamp"), dict) else parts
            nanoseconds = next((name for name in ("nsec", "nanosec") if name in parts), "nsec")
            return _number(parts, "sec", math.nan) + 1e-9 * _number(parts, nanoseconds, 0.0)
        if value is not None and not isinstance(value, str):
            return _float(value)
    return math.nan


def _number(fields: Mapping[str, Any], name: str, default: float) -> float:
    value = fields.get(name)
    return default if value is None else _float(value)


def _float(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise BadRecord("a number is missing")
    try:
        return float(value)
    except OverflowError as problem:
        raise BadRecord("a number is too large") from problem
