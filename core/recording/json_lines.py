"""Scans as text, one JSON object a line."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from core.errors import BadInput
from core.recording.clocks import seconds_per_unit
from core.recording.json_scan import read_json_scan
from core.recording.read_report import BadRecord, ReadReport
from core.recording.recording import LogSettings, ScanRecording
from core.recording.scans import scan_recording
from core.recording.source import TextLog
from core.sensors import Scan


def read(path: Path, settings: LogSettings) -> ScanRecording:
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
