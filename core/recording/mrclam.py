"""Folders in the MRCLAM form: `Barcodes.dat`, `RobotK_Odometry.dat`, `RobotK_Measurement.dat`, plain or gzip'ed.

Odometry: time, speed [m/s], turn rate [rad/s], held until the next. Measurement: time, BARCODE, range [m], bearing
[rad]. Barcodes: subject, barcode; subjects 1-5 are robots.
"""

import math
from array import array
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from core.errors import BadInput
from core.geometry import Pose, wrap
from core.message import Array
from core.recording.clocks import seconds_per_unit
from core.recording.read_report import ReadReport
from core.recording.recording import LogSettings, SightingRecording
from core.recording.sightings import MAX_BEARING_RAD, MAX_TURN_RATE_RAD_S, Ids, SightingSteps, grouped, in_radians
from core.recording.source import TextLog
from core.slam.motion import Increment


def read_columns(path: Path, columns: int, largest: int, tally: ReadReport) -> Array:
    """A table → (N, columns) of finite numbers; other lines are counted as skipped. Raises BadInput.

    Where `path` is absent, the same name with `.gz` is read.
    """
    path = path if path.exists() else path.with_name(path.name + ".gz")
    if not path.exists():
        raise BadInput(f"{path.name.removesuffix('.gz')} is missing in {path.parent.name}.")
    text = TextLog(path, largest)
    numbers = array("d")
    for number, line in text:
        if not line or line.startswith("#"):
            continue
        words = line.replace(",", " ").replace(";", " ").split()
        try:
            row = [float(word) for word in words[:columns]]
        except ValueError:
            row = []
        if len(row) < columns or not all(abs(value) < MAX_STAMP_NS for value in row):
            tally.skip("it is cut or no numbers", f"line {number} of {path.name}")
            continue
        numbers.extend(row)
    if text.cut:
        tally.skip("the packed file is cut or damaged here", path.name)
    return np.array(numbers).reshape(-1, columns)


MAX_STAMP_NS = 1e20  # of a row's time, in whatever unit
LAST_ROBOT = 5  # subjects up to this number drive around and are no landmarks
FORWARD_NOISE = 0.03  # [m/√s] while moving
TURN_NOISE = math.radians(2.0)  # [rad/√s] while moving
SIGHTING_NOISE = 0.15, math.radians(1.0)  # [m], [rad]
STILL_SPEED = 1e-6  # [m/s + rad/s]


def read(folder: Path, robot: int, ids: Ids, settings: LogSettings) -> SightingRecording:
    """One robot's landmark sightings within the time of its odometry, one step per instant. Raises BadInput."""
    tally = ReadReport(folder)
    subjects = {
        int(code): int(subject)
        for subject, code in read_columns(folder / "Barcodes.dat", 2, settings.largest_file, tally).tolist()
    }
    odometry = _robot_file(folder, robot, "Odometry", 3, settings, tally)
    rows = _robot_file(folder, robot, "Measurement", 4, settings, tally)
    odometry = odometry[np.argsort(odometry[:, 0], kind="stable")]
    odometry[:, 2] = in_radians(odometry[:, 2], MAX_TURN_RATE_RAD_S, f"Robot{robot}_Odometry", tally)
    rows[:, 3] = in_radians(rows[:, 3], MAX_BEARING_RAD, f"Robot{robot}_Measurement", tally)
    if len(odometry) < 2:
        raise BadInput(f"The odometry of robot {robot} in {folder.name} has fewer than two lines.")
    names = np.array([subjects.get(int(code), 0) for code in rows[:, 1]])
    tally.skip("its barcode is unknown", count=int((names == 0).sum()))
    within = (rows[:, 0] >= odometry[0, 0]) & (rows[:, 0] <= odometry[-1, 0]) & (names > LAST_ROBOT)
    times, index = np.unique(rows[within, 0], return_inverse=True)
    by_time = grouped(index, np.column_stack([names[within], rows[within, 2:]]))
    steps = SightingSteps(SIGHTING_NOISE, ids, tally)
    for number, (stamp, moved) in enumerate(zip(times.tolist(), _moves(odometry, times), strict=True)):
        steps.add(stamp, moved, by_time[number])
    tally.topics = [f"Robot{robot}_Odometry: odometry", f"Robot{robot}_Measurement: sightings"]
    return steps.finish(folder, "MRCLAM folder")


def _robot_file(folder: Path, robot: int, what: str, columns: int, settings: LogSettings, tally: ReadReport) -> Array:
    path = folder / f"Robot{robot}_{what}.dat"
    if not path.exists() and not path.with_name(path.name + ".gz").exists():
        there = sorted(p.name[5:].split("_")[0] for p in folder.glob("Robot*_Odometry.dat*"))
        raise BadInput(
            f"{folder.name} has no robot {robot}; it has {', '.join(there) or 'none'}. Say which after #, such as #1."
        )
    rows = read_columns(path, columns, settings.largest_file, tally)
    rows[:, 0] *= seconds_per_unit(np.sort(rows[:, 0]), path.stem, tally)
    return rows


def _moves(odometry: Array, times: Array) -> Iterator[Increment]:
    """Odometry (N, 3) in time order → the move up to each of `times` since the one before, or since row 0."""
    starts = odometry[:, 0]
    begin = starts[0]
    for stamp in times:
        first, last = np.searchsorted(starts, begin, "right") - 1, np.searchsorted(starts, stamp, "left")
        seconds = np.diff(np.concatenate([[begin], starts[first + 1 : last], [stamp]]))
        yield _rolled(odometry[first:last, 1], odometry[first:last, 2], seconds) if stamp > begin else Increment()
        begin = stamp


def _rolled(speeds: Array, turn_rates: Array, seconds: Array) -> Increment:
    """Speeds (N,) and turn rates (N,), each held for `seconds` (N,) → the whole move and its covariance.

    The heading in the middle of a step gives its direction. An error of a step's way shifts the end along that
    direction; an error of its turn swings all that comes after it.
    """
    ways, turns = speeds * seconds, turn_rates * seconds
    headings = np.cumsum(turns)
    ahead = np.stack([np.cos(headings - turns / 2), np.sin(headings - turns / 2)])
    places = np.cumsum(ways * ahead, axis=1)
    x, y = places[:, -1]
    after = places[:, -1:] - places + ways * ahead / 2
    by_way = np.vstack([ahead, np.zeros_like(ways)])
    by_turn = np.vstack([-after[1], after[0], np.ones_like(ways)])
    moving = seconds * (np.abs(speeds) + np.abs(turn_rates) >= STILL_SPEED)
    covariance = FORWARD_NOISE**2 * (by_way * moving) @ by_way.T + TURN_NOISE**2 * (by_turn * moving) @ by_turn.T
    return Increment(Pose(float(x), float(y), wrap(float(headings[-1]))), covariance)
