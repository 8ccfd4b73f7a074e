"""CARMEN text logs: one record a line.

FLASER n r₁…rₙ  x y θ of the laser  x y θ of the robot  time host logger_time
ROBOTLASER1 type start field step maximum accuracy remission n r₁…rₙ m e₁…eₘ  laser x y θ  robot x y θ  tv rv … time …
ODOM x y θ tv rv acceleration time host logger_time. Metres, radians, seconds.
"""

from __future__ import annotations

from array import array
from pathlib import Path

import numpy as np

from core.errors import BadInput
from core.geometry import Pose
from core.message import Array
from core.recording.odometry_track import OdometryTrack
from core.recording.read_report import BadRecord, ReadReport
from core.recording.recording import LogSettings, ScanRecording
from core.recording.scans import in_time_order, make_scan, scan_recording, spread
from core.recording.source import TextLog
from core.sensors import Scan

NO_RETURN = 80.0  # [m]: readings from here on mean that nothing came back
FORM = "CARMEN text"
KNOWN = ("FLASER", "ROBOTLASER1", "ODOM")


def read(path: Path, settings: LogSettings) -> ScanRecording:
    """A CARMEN log, plain or gzip'ed → the recording. Raises BadInput."""
    log, tally = _Carmen(settings), ReadReport(path)
    text = TextLog(path, settings.largest_file)
    others = 0
    for number, line in text:
        word = line.split(" ", 1)[0]
        if word not in KNOWN:
            others += bool(line) and not line.startswith("#")
            continue
        if log.held > settings.most_readings:
            tally.warn(
                "The log is longer than log.most_readings_mb of the settings allows; only the first part is used."
            )
            break
        try:
            log.take(word, line.split())
            tally.read += 1
        except (BadRecord, ValueError, IndexError, OverflowError) as problem:
            tally.skip(
                str(problem) if isinstance(problem, BadRecord) else "it is cut or no numbers", f"line {number}"
            )
    if text.cut:
        tally.skip("the packed file is cut or damaged here")
    return log.finish(path, tally, others)


class _Carmen:
    """Takes lines one by one."""

    def __init__(self, settings: LogSettings):
        self._settings = settings
        self._scans: list[Scan] = []
        self._beside = array("d")  # with every scan: laser x y θ, robot x y θ
        self._odometry = array("d")  # time x y θ tv rv …
        self.held = 0  # [bytes]

    def take(self, word: str, words: list[str]) -> None:
        """One line. Raises BadRecord, ValueError, IndexError."""
        if word == "ODOM":
            x, y, heading, speed, turn_rate = (_finite(text) for text in words[1:6])
            self._odometry.extend((_time(words, 7), x, y, heading, speed, turn_rate))
            self.held += 48
        elif word == "FLASER":
            beams = _count(words[1])
            after = 2 + beams
            self._keep(
                words[2:after], spread(max(beams, 1)), NO_RETURN, words[after : after + 6], _time(words, after + 6)
            )
        else:
            start, step, maximum = _finite(words[2]), _finite(words[4]), _finite(words[5])
            beams = _count(words[8])
            after = 9 + beams
            after += 1 + _count(words[after])
            poses = words[after : after + 6]
            self._keep(words[9 : 9 + beams], (start, step), maximum, poses, _time(words, after + 11))

    def _keep(
        self, ranges: list[str], angles: tuple[float, float], maximum: float, poses: list[str], stamp: float
    ) -> None:
        beside = [_finite(text) for text in poses]
        if len(beside) < 6:
            raise BadRecord("it is cut or no numbers")
        maximum = self._settings.range_max or maximum
        scan = make_scan(stamp, np.array(ranges, np.float64), angles, (0.0, maximum))
        self._scans.append(scan)
        self._beside.extend(beside)
        self.held += 600 + scan.ranges.nbytes

    def finish(self, path: Path, tally: ReadReport, others: int) -> ScanRecording:
        """All lines taken → the recording."""
        if not self._scans:
            reasons = f" What could not be read: {tally.reasons()}." if tally.skipped else ""
            raise BadInput(
                f"{path.name} holds no FLASER or ROBOTLASER1 line, so it is no CARMEN log with scans.{reasons}"
            )
        beside = np.array(self._beside).reshape(-1, 6)
        stamps = np.array([scan.stamp for scan in self._scans])
        odometry = np.array(self._odometry).reshape(-1, 6)
        lasers, robots = beside[:, :3], beside[:, 3:]
        if np.ptp(robots, axis=0).max() > 0:
            track, source = OdometryTrack.of(stamps, robots), "robot pose beside the scans: odometry"
        else:
            track, source = OdometryTrack.of(odometry[:, 0], odometry[:, 1:4], odometry[:, 4:]), "ODOM: odometry"
        tally.topics = ["FLASER, ROBOTLASER1: laser"] + ([source] if track is not None else [])
        mounting = _mounting(robots, lasers, tally)
        scans = in_time_order(self._scans, tally)
        if others:
            tally.topics.append(f"{others} lines of other kinds are not used")
        return scan_recording(path, scans, track, tally, FORM, self._settings, mounting)


def _mounting(robots: Array, lasers: Array, tally: ReadReport) -> Pose:
    """Poses (N, 3) of robot and laser in one frame → robot_from_laser, when it is the same all the time."""
    seen = [(Pose(*r).inverse() @ Pose(*la)).vector for r, la in zip(robots.tolist(), lasers.tolist(), strict=True)]
    middle = np.median(seen, axis=0)
    if np.ptp(np.array(seen)[:, :2], axis=0).max() > 0.05:
        if np.any(lasers):
            tally.warn(
                "The laser's poses are those of a corrected map, not of its mounting; it is taken to stand at "
                "the robot's origin."
            )
        return Pose()
    return Pose(*(float(number) if abs(number) > 1e-4 else 0.0 for number in middle))


def _time(words: list[str], at: int) -> float:
    """The record's time [s] at word `at`, or the logger's time at the end where that word is missing."""
    return _finite(words[at]) if len(words) > at else _finite(words[-1])


def _finite(text: str) -> float:
    number = float(text)
    if not abs(number) < 1e12:
        raise BadRecord("a number cannot be")
    return number


def _count(text: str) -> int:
    number = int(text)
    if not 0 <= number <= 20_000:
        raise BadRecord("its number of beams cannot be")
    return number
