"""Scans written as JSON: each a line of a text log, or a message of a JSON channel."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
from msgspec import UNSET, UnsetType

from core.errors import BadInput
from core.recording.clocks import seconds_per_unit
from core.recording.read_report import BadRecord, ReadReport
from core.recording.recording import LogSettings, ScanRecording
from core.recording.scans import default_angles, make_scan, scan_recording
from core.recording.source import TextLog
from core.sensors import Scan

MAX_TEXT_BYTES = 4_000_000


class ClockTime(msgspec.Struct, frozen=True):
    """A time in two parts as ROS writes it, or a header that has one."""

    sec: float | None = None  # [s]
    nsec: float | None = None  # [ns]
    nanosec: float | None = None  # [ns], as ROS 2 calls it
    stamp: ClockTime | float | str | None = None

    @property
    def seconds(self) -> float:
        """Both parts together [s], or NaN."""
        if isinstance(self.stamp, ClockTime):
            return self.stamp.seconds
        return _or(self.sec, math.nan) + 1e-9 * _or(self.nsec, _or(self.nanosec, 0.0))


class JsonScan(msgspec.Struct, frozen=True):
    """The keys of a scan that are read; others may be there. A null stands for a number that is not known."""

    ranges: list[float | None]  # [m]; null: no measurement
    t: float | ClockTime | str | None = None  # [s]
    stamp: float | ClockTime | str | None = None
    timestamp: float | ClockTime | str | None = None
    header: float | ClockTime | str | None = None
    angle_min: float | UnsetType | None = UNSET  # [rad]
    angle_increment: float | UnsetType | None = UNSET
    angle_step: float | None = None
    start_angle: float | UnsetType | None = UNSET
    end_angle: float | None = None
    range_min: float | None = None  # [m]
    range_max: float | None = None
    time_increment: float | None = None  # [s] from beam to beam

    @property
    def seconds(self) -> float:
        """The time [s], or NaN."""
        for value in (self.t, self.stamp, self.timestamp, self.header):
            if isinstance(value, ClockTime):
                return value.seconds
            if isinstance(value, float):
                return value
        return math.nan

    @property
    def angles(self) -> tuple[float, float]:
        """The first beam's angle and the step to the next [rad]."""
        if self.angle_min is not UNSET:
            step = self.angle_step if self.angle_increment is UNSET else self.angle_increment
            return _or(self.angle_min, math.nan), _or(step, math.nan)
        beams = max(1, len(self.ranges))
        if self.start_angle is not UNSET:
            start, end = _or(self.start_angle, math.nan), _or(self.end_angle, math.nan)
            return start, (end - start) / max(1, beams - 1)
        return default_angles(beams)


def read_json_scan(text: str | bytes, range_max: float) -> Scan | None:
    """One JSON object → its scan; None when it is an object without ranges. Raises BadRecord.

    Ranges in metres, null = no measurement. Angles by `angle_min` and `angle_increment` (or `angle_step`), or
    `start_angle` and `end_angle`; without them the beams are spread over 180°. Time `t`, `stamp`, `timestamp` or
    `header.stamp`; without one the stamp is NaN. `range_max` [m] of the settings, 0: as the scan says.
    """
    if len(text) > MAX_TEXT_BYTES:
        raise BadRecord("it is too long")
    try:
        record = json.loads(text)  # many programs write NaN and Infinity, which are no JSON; msgspec refuses them
    except (ValueError, RecursionError) as problem:
        raise BadRecord("it is no JSON, or cut" if text else "it is empty") from problem
    if not isinstance(record, dict):
        raise BadRecord("it is no JSON object")
    if "ranges" not in record:
        return None
    try:
        read = msgspec.convert(record, JsonScan)
    except msgspec.ValidationError as problem:
        raise BadRecord(_fault(str(problem))) from problem
    except (UnicodeEncodeError, RecursionError) as problem:
        raise BadRecord("it is no JSON, or cut") from problem
    high, low = range_max or _or(read.range_max, math.nan), _or(read.range_min, 0.0)
    limits = (low if math.isfinite(low) else 0.0, high if math.isfinite(high) else None)
    ranges = np.array(read.ranges, np.float64)  # None becomes NaN
    scan = make_scan(read.seconds, ranges, read.angles, limits, _or(read.time_increment, 0.0))
    if np.isnan(scan.ranges).all():
        raise BadRecord("none of its beams measured anything")
    return scan


def read_json_lines(path: Path, settings: LogSettings) -> ScanRecording:
    """A JSON-lines log, plain or gzip'ed → the recording. Lines that cannot be used are counted. Raises BadInput."""
    tally = ReadReport(path)
    text = TextLog(path, settings.largest_file)
    scans: list[Scan] = []
    held = 0
    for number, line in text:
        if held > settings.most_readings:
            tally.warn(
                "The log is longer than log.most_readings_mb of the settings allows; only the first part is used."
            )
            break
        try:
            scan = read_json_scan(line, settings.range_max)
            if scan is None:
                continue
            if not math.isfinite(scan.stamp):
                raise BadRecord("it has no time")
            if scans and scan.stamp <= scans[-1].stamp:
                raise BadRecord("its time goes backwards")
        except BadRecord as problem:
            tally.skip(str(problem), f"line {number}")
            continue
        scans.append(scan)
        tally.read += 1
        held += 500 + scan.ranges.nbytes
    if text.cut:
        tally.skip("the packed file is cut or damaged here")
    if not scans:
        reasons = f" What could not be read: {tally.reasons()}." if tally.skipped else ""
        raise BadInput(
            f'{path.name} holds no scans: lines like {{"t": 0.1, "ranges": [1.0, 2.0]}} are expected.{reasons}'
        )
    tally.topics = ["ranges: laser"]
    unit = seconds_per_unit(np.array([scan.stamp for scan in scans]), "the laser", tally)
    scans = [replace(scan, stamp=unit * scan.stamp) for scan in scans] if unit != 1.0 else scans
    return scan_recording(path, scans, None, tally, "JSON lines", settings)


def _fault(problem: str) -> str:
    if "$.ranges[" in problem:
        return "its ranges are no numbers"
    if "$.ranges" in problem:
        return "its ranges are no list"
    return "a number is too large" if "out of range" in problem else "a number is missing"


def _or(value: float | None, default: float) -> float:
    return default if value is None else value
