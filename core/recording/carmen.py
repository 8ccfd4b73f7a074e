"""CARMEN text logs: one record a line, its words apart by blanks or tabs.

FLASER n r₁…rₙ  x y θ of the laser  x y θ of the robot  time host logger_time
RAWLASER1 type start field step maximum accuracy remission n r₁…rₙ m e₁…eₘ  time host logger_time
ROBOTLASER1 type start field step maximum accuracy remission n r₁…rₙ m e₁…eₘ  laser x y θ  robot x y θ  tv rv … time …
ODOM x y θ tv rv acceleration time host logger_time. Metres, radians, seconds.
PARAM laser_front_laser_fov (field of FLASER's beams), laser_front_laser_flipped and robot_frontlaser_offset count.
"""

import math
import re
from array import array
from pathlib import Path

import numpy as np

from core.errors import BadInput
from core.geometry import Pose
from core.message import Array
from core.recording.clocks import StampedStream, evenly_spread, seconds_per_unit, settled_stamps, unwrapped
from core.recording.laser_sense import with_laser_as_driven
from core.recording.odometry_checks import believable_track
from core.recording.read_report import BadRecord, ReadReport
from core.recording.recording import LogSettings, ScanRecording, stamped
from core.recording.scans import default_angles, in_time_order, make_scan, on_a_clock_that_goes_on, scan_recording
from core.recording.source import TextLog
from core.sensors import Scan
from core.sensors.scan_gate import RangeUnit, checked_angles

MAX_STAMP_NS = 1e20  # of a record's time, in whatever unit
NO_RETURN_RANGE_M = 80.0  # readings from here on mean that nothing came back
FORM = "CARMEN text"
LASER = re.compile(r"[FR]LASER|(ROBOT|RAW)LASER\d")
LASER_NAMES = ("FLASER", "ROBOTLASER1", "RAWLASER1")  # the first of several that have about as many scans
BEARING_MARGIN_RAD = 0.02  # by which a field of a whole turn may be written too wide


def read(path: Path, settings: LogSettings) -> ScanRecording:
    """A CARMEN log, plain or gzip'ed → the recording. Raises BadInput."""
    tally = ReadReport(path)
    log = _Carmen(settings, tally)
    text = TextLog(path, settings.largest_file)
    others = 0
    for number, line in text:
        if not is_known(line):
            others += bool(line) and not line.startswith("#")
            continue
        if log.held > settings.most_readings:
            tally.warn(
                "The log is longer than log.most_readings_mb of the settings allows; only the first part is used."
            )
            break
        try:
            words = words_of(line)
            log.take(words[0], words)
            tally.read += words[0] != "PARAM"
        except (BadRecord, ValueError, IndexError, OverflowError) as problem:
            tally.skip(
                str(problem) if isinstance(problem, BadRecord) else "it is cut or no numbers", f"line {number}"
            )
    if text.cut:
        tally.skip("the packed file is cut or damaged here")
    return log.finish(path, tally, others)


def is_known(line: str) -> bool:
    """Return whether a line is a record that is read."""
    first = re.split(r"[\s,;]", line, maxsplit=1)[0].upper()
    return first in ("ODOM", "PARAM") or bool(LASER.fullmatch(first))


def words_of(line: str) -> list[str]:
    """A record → its words, whatever stands between them; commas may be decimal points, what follows # is none."""
    line = line.partition(" #")[0].replace(";", " ")
    words = line.replace(",", " " if "." in line else ".").split()
    return [words[0].upper(), *words[1:]]


class _Carmen:
    def __init__(self, settings: LogSettings, tally: ReadReport):
        self._settings = settings
        self._scans: list[Scan] = []
        self._times: list[tuple[float, float]] = []  # of every scan: its own, and the logger's, in any unit
        self._kinds: list[str] = []  # of the record of every scan
        self._unit, self._tally = RangeUnit("the laser", tally), tally
        self._beside = array("d")  # with every scan: laser x y θ, robot x y θ; NaN where it carries none
        self._odometry = array("d")  # time, logger's time, x y θ tv rv …
        self._field: float | None = None  # [rad] of FLASER's beams, where the header says it
        self._flipped = False  # the beams go from left to right
        self._offset = 0.0  # [m] of the laser ahead of the robot's middle, for records without poses
        self.held = 0  # [bytes]

    def take(self, word: str, words: list[str]) -> None:
        """One line. Raises BadRecord, ValueError, IndexError."""
        if word == "PARAM":
            self._take_header(words)
        elif word == "ODOM":
            x, y, heading, speed, turn_rate = (_finite(text) for text in words[1:6])
            self._odometry.extend((*_times(words, 7), x, y, heading, speed, turn_rate))
            self.held += 56
        elif word in ("FLASER", "RLASER"):
            beams = _count(words[1])
            after = 2 + beams
            if len(words) > after + 9:
                raise BadRecord("it has more numbers than it says")
            self._keep(word, words[2:after], self._spread(beams), math.nan, words[after:], 6)
        else:
            start, step, maximum = _finite(words[2]), _finite(words[4]), _finite(words[5])
            beams = _count(words[8])
            field = _finite(words[3])
            step = step or field / max(1, beams - 1)
            start, step = checked_angles("the laser", beams, (start, start + field), step, self._tally)
            after = 9 + beams
            after += 1 + _count(words[after])
            time_at = 11 if word.startswith("ROBOT") else 0
            self._keep(word, words[9 : 9 + beams], (start, step), maximum, words[after:], time_at)

    def _take_header(self, words: list[str]) -> None:
        """One entry of the header, which says what the records do not."""
        if len(words) < 3:
            return
        name, value = words[1], words[2]
        if name == "laser_front_laser_fov":
            field = _finite(value)
            self._field = math.radians(field) if field > math.tau + BEARING_MARGIN_RAD else field
        elif name == "laser_front_laser_flipped":
            self._flipped = value in ("1", "on", "true")
        elif name == "robot_frontlaser_offset":
            self._offset = _finite(value)

    def _spread(self, beams: int) -> tuple[float, float]:
        """Beams of a FLASER record → (angle_min, angle_step) [rad], by the header where it says their field."""
        if self._field is None or beams < 2:
            return default_angles(max(beams, 1))
        around = self._field > math.tau - BEARING_MARGIN_RAD
        half, apart = (
            default_angles(beams)
            if abs(self._field - math.pi) < BEARING_MARGIN_RAD
            else (-self._field / 2, self._field / (beams if around else beams - 1))
        )
        return half, apart

    def _keep(
        self, kind: str, ranges: list[str], angles: tuple[float, float], maximum: float, rest: list[str], time_at: int
    ) -> None:
        """One scan; `rest`: the words behind its ranges, of which that at `time_at` is its time."""
        beside = [_finite(text) for text in rest[:6]] if time_at else [math.nan] * 6
        if len(beside) < 6:
            raise BadRecord("it is cut or no numbers")
        row, (_, high) = self._unit.metres(np.array(ranges, np.float64), (0.0, maximum))
        maximum = self._settings.range_max or (high if high > 0 else NO_RETURN_RANGE_M)
        times = _times(rest, time_at)
        scan = make_scan(0.0, row[::-1] if self._flipped else row, angles, (0.0, maximum))
        self._scans.append(scan)
        self._kinds.append(kind)
        self._times.append(times)
        self._beside.extend(beside)
        self.held += 600 + scan.ranges.nbytes

    def finish(self, path: Path, tally: ReadReport, others: int) -> ScanRecording:
        if not self._scans:
            reasons = f" What could not be read: {tally.reasons()}." if tally.skipped else ""
            raise BadInput(
                f"{path.name} holds no FLASER, ROBOTLASER1 or RAWLASER1 line, so it is no CARMEN log with scans."
                f"{reasons}"
            )
        used = self._chosen(tally)
        scans = [self._scans[row] for row in used.tolist()]
        beside = np.array(self._beside).reshape(-1, 6)[used]
        odometry = np.array(self._odometry).reshape(-1, 7)
        lasers, robots = beside[:, :3], beside[:, 3:]
        posed = np.isfinite(robots).all(axis=1)
        own, logged = (unwrapped(times, "the laser", tally) for times in np.array(self._times)[used].T)
        units = seconds_per_unit(own, "the laser", tally), seconds_per_unit(logged, "the laser", tally)
        stamps = self._settled(own * units[0], logged * units[1], "the laser", tally, robots[:, :2])
        if posed.any() and np.ptp(robots[posed], axis=0).max() > 0:
            (stamps,) = on_a_clock_that_goes_on(scans, [stamps], tally)
            track = believable_track("the poses beside the scans", stamps[posed], robots[posed], None, tally)
            source = "robot pose beside the scans: odometry"
        else:
            odometry[:, 0], odometry[:, 1] = (
                unit * unwrapped(times, "ODOM", tally) for unit, times in zip(units, odometry[:, :2].T, strict=True)
            )
            times = self._settled(odometry[:, 0], odometry[:, 1], "ODOM", tally)
            stamps, times = on_a_clock_that_goes_on(scans, [stamps, times], tally)
            track, source = (
                believable_track("ODOM", times, odometry[:, 2:5], odometry[:, 5:], tally),
                "ODOM: odometry",
            )
        tally.topics = ["FLASER, ROBOTLASER1, RAWLASER1: laser"] + ([source] if track is not None else [])
        mounting = _mounting(robots[posed], lasers[posed], tally) if posed.any() else Pose(x=self._offset)
        dated = [stamped(scan, float(stamp)) for scan, stamp in zip(scans, stamps, strict=True)]
        scans = in_time_order(dated, tally)
        if others:
            tally.topics.append(f"{others} lines of other kinds are not used")
        recording = scan_recording(path, scans, track, tally, FORM, self._settings, mounting)
        return with_laser_as_driven(
            recording, heading=self._settings.mounting_heading is None and not mounting.heading
        )

    def _chosen(self, tally: ReadReport) -> Array:
        """Rows of the scans of one laser, (N,)."""
        kinds = np.array(self._kinds)
        names, counts = np.unique(kinds, return_counts=True)
        many = [str(name) for name, count in zip(names, counts, strict=True) if 2 * count >= counts.max()]
        name = next((one for one in LASER_NAMES if one in many), many[0])
        others = sorted({str(one) for one in names} - {name})
        if others:
            tally.warn(f"Of several lasers {name} is used; {', '.join(others)} is not.")
        return np.flatnonzero(kinds == name)

    @staticmethod
    def _settled(own: Array, logged: Array, name: str, tally: ReadReport, places: Array | None = None) -> Array:
        """Times in the records and by the logger (N,) [s] → those to use; where neither has a value, evenly."""
        return evenly_spread(settled_stamps(StampedStream(name, own, logged), tally)[0].own, tally, name, places)


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


def _times(words: list[str], at: int) -> tuple[float, float]:
    """The record's time at word `at`, and the logger's at the end, which stands in where that word is missing."""
    logged = _finite(words[-1], MAX_STAMP_NS)
    return (_finite(words[at], MAX_STAMP_NS) if len(words) > at else logged), logged


def _finite(text: str, most: float = 1e12) -> float:
    number = float(text)
    if not abs(number) < most:
        raise BadRecord("a number cannot be")
    return number


def _count(text: str) -> int:
    number = int(text)
    if not 0 <= number <= 20_000:
        raise BadRecord("its number of beams cannot be")
    return number
