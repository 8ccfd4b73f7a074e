"""Scans written as JSON: each a line of a text log, or a message of a JSON channel."""

from __future__ import annotations

import contextlib
import datetime
import json
import math
from pathlib import Path

import msgspec
import numpy as np
from msgspec import UNSET, UnsetType

from core.errors import BadInput
from core.recording.clocks import evenly_spread, seconds_per_unit, unwrapped
from core.recording.read_report import BadRecord, ReadReport
from core.recording.recording import LogSettings, ScanRecording, stamped
from core.recording.scans import default_angles, in_time_order, make_scan, on_a_clock_that_goes_on, scan_recording
from core.recording.source import TextLog
from core.sensors import Scan
from core.sensors.scan_gate import RangeUnit, checked_angles

MAX_TEXT_BYTES = 4_000_000
MAX_TIME = 1e20  # of a record, in whatever unit


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
    time: float | ClockTime | str | None = None
    ts: float | ClockTime | str | None = None
    header: float | ClockTime | str | None = None
    angle_min: float | UnsetType | None = UNSET  # [rad]
    angle_increment: float | UnsetType | None = UNSET
    angle_step: float | None = None
    angle_max: float | None = None
    start_angle: float | UnsetType | None = UNSET
    end_angle: float | None = None
    range_min: float | None = None  # [m]
    range_max: float | None = None
    time_increment: float | None = None  # [s] from beam to beam

    @property
    def seconds(self) -> float:
        """The time in the unit that it is written in, of a date since 1970 [s]; or NaN."""
        for value in (self.t, self.stamp, self.timestamp, self.time, self.ts, self.header):
            if isinstance(value, ClockTime):
                return value.seconds
            if isinstance(value, float):
                return value
            if isinstance(value, str) and math.isfinite(seconds := _seconds_in(value)):
                return seconds
        return math.nan

    def angles(self, unit: RangeUnit) -> tuple[float, float]:
        """The first beam's angle and the step to the next [rad]."""
        beams = max(1, len(self.ranges))
        if self.angle_min is UNSET and self.start_angle is UNSET:
            unit.report.fault("scan.no_angles", unit.name, used=True)
            return default_angles(beams)
        first, step, last = self.angle_min, self.angle_step, self.angle_max
        if first is UNSET:
            first, step, last = self.start_angle, None, self.end_angle
        elif self.angle_increment is not UNSET:
            step = self.angle_increment
        ends = _or(None if first is UNSET else first, math.nan), _or(last, math.nan)
        between = (ends[1] - ends[0]) / max(1, beams - 1)
        return checked_angles(unit.name, beams, ends, _or(step, between), unit.report)


def read_json_scan(text: str | bytes, range_max: float, unit: RangeUnit) -> tuple[Scan, float] | None:
    """One JSON object → its scan, without a stamp, and its time; None when it is an object without ranges.

    Ranges in metres, null = no measurement; what else they are, `unit` finds. Angles by `angle_min` and
    `angle_increment` (or `angle_step`, or `angle_max`), or `start_angle` and `end_angle`; without them the beams are
    spread over 180°. Time `t`, `stamp`, `timestamp`, `time`, `ts` or `header.stamp` in any unit, or as a date; NaN
    without one. `range_max` [m] of the settings, 0: as the scan says. Raises BadRecord, UnusableReading.
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
    high, low = _or(read.range_max, math.nan), _or(read.range_min, 0.0)
    ranges = np.array(read.ranges, np.float64)  # None becomes NaN
    ranges, (low, high) = unit.metres(ranges, (low if math.isfinite(low) else 0.0, high))
    high = range_max or high
    limits = (low, high if math.isfinite(high) else None)
    scan = make_scan(0.0, ranges, read.angles(unit), limits, _or(read.time_increment, 0.0))
    if np.isnan(scan.ranges).all():
        raise BadRecord("none of its beams measured anything")
    return scan, read.seconds


def read_json_lines(path: Path, settings: LogSettings) -> ScanRecording:
    """A JSON-lines log, plain or gzip'ed → the recording. Lines that cannot be used are counted. Raises BadInput."""
    tally = ReadReport(path)
    text = TextLog(path, settings.largest_file)
    unit = RangeUnit("the laser", tally)
    scans: list[Scan] = []
    times: list[float] = []
    held = 0
    for number, line in text:
        if held > settings.most_readings:
            tally.warn(
                "The log is longer than log.most_readings_mb of the settings allows; only the first part is used."
            )
            break
        try:
            read = read_json_scan(line, settings.range_max, unit)
            if read is None:
                continue
            scan, time = read
            if not abs(time) < MAX_TIME:
                raise BadRecord('it has no time such as "t": 0.1' if math.isnan(time) else "its time cannot be")
        except BadRecord as problem:
            tally.skip(str(problem), f"line {number}")
            continue
        scans.append(scan)
        times.append(time)
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
    stamps = unwrapped(np.array(times), "the laser", tally)
    stamps = evenly_spread(seconds_per_unit(stamps, "the laser", tally) * stamps, tally, "the laser")
    (stamps,) = on_a_clock_that_goes_on(scans, [stamps], tally)
    dated = (stamped(scan, float(stamp)) for scan, stamp in zip(scans, stamps, strict=True))
    scans = in_time_order(list(dated), tally)
    return scan_recording(path, scans, None, tally, "JSON lines", settings)


def _fault(problem: str) -> str:
    if "$.ranges[" in problem:
        return "its ranges are no numbers"
    if "$.ranges" in problem:
        return "its ranges are no list"
    return "a number is too large" if "out of range" in problem else "a number is missing"


def _seconds_in(text: str) -> float:
    """A number, or a date of ISO 8601 (UTC where it names no zone), as text → [s]; NaN for all else."""
    with contextlib.suppress(ValueError):
        return float(text)
    with contextlib.suppress(ValueError, OverflowError):
        date = datetime.datetime.fromisoformat(text)
        return (date if date.tzinfo else date.replace(tzinfo=datetime.UTC)).timestamp()
    return math.nan


def _or(value: float | None, default: float) -> float:
    return default if value is None else value
