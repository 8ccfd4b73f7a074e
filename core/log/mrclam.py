"""Folders in the MRCLAM form: `Barcodes.dat`, `RobotK_Odometry.dat`, `RobotK_Measurement.dat`, plain or gzip'ed.

Odometry: time, speed [m/s], turn rate [rad/s], held until the next. Measurement: time, BARCODE, range [m], bearing
[rad]. Barcodes: subject, barcode; subjects 1-5 are robots.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from core.errors import BadInput
from core.geometry import Pose
from core.log.columns import read_columns
from core.log.recording import LogSettings, SightingRecording
from core.log.sightings import Ids, Steps, grouped
from core.log.tally import Tally
from core.message import Array
from core.slam.motion import Increment, control_jacobian

LAST_ROBOT = 5  # subjects up to this number drive around and are no landmarks
FORWARD_NOISE = 0.03  # [m/√s] while moving
TURN_NOISE = math.radians(2.0)  # [rad/√s] while moving
SIGHTING_NOISE = 0.15, math.radians(1.0)  # [m], [rad]
STILL = 1e-6  # [m/s + rad/s]


def read(folder: Path, robot: int, ids: Ids, settings: LogSettings) -> SightingRecording:
    """One robot's landmark sightings within the time of its odometry, one step per instant. Raises BadInput."""
    tally = Tally(folder)
    subjects = {
        int(code): int(subject)
        for subject, code in read_columns(folder / "Barcodes.dat", 2, settings.largest_file, tally).tolist()
    }
    odometry = _robot_file(folder, robot, "Odometry", 3, settings, tally)
    rows = _robot_file(folder, robot, "Measurement", 4, settings, tally)
    odometry = odometry[np.argsort(odometry[:, 0], kind="stable")]
    if len(odometry) < 2:
        raise BadInput(f"The odometry of robot {robot} in {folder.name} has fewer than two lines.")
    names = np.array([subjects.get(int(code), 0) for code in rows[:, 1]])
    tally.skip("its barcode is unknown", count=int((names == 0).sum()))
    within = (rows[:, 0] >= odometry[0, 0]) & (rows[:, 0] <= odometry[-1, 0]) & (names > LAST_ROBOT)
    times, index = np.unique(rows[within, 0], return_inverse=True)
    by_time = grouped(index, np.column_stack([names[within], rows[within, 2:]]))
    steps = Steps(SIGHTING_NOISE, ids, tally)
    for number, (stamp, moved) in enumerate(zip(times.tolist(), _moves(odometry, times), strict=True)):
        steps.add(stamp, moved, by_time[number])
    tally.topics = [f"Robot{robot}_Odometry: odometry", f"Robot{robot}_Measurement: sightings"]
    return steps.finish(folder, "MRCLAM folder")


def _robot_file(folder: Path, robot: int, what: str, columns: int, settings: LogSettings, tally: Tally) -> Array:
    path = folder / f"Robot{robot}_{what}.dat"
    if not path.exists() and not path.with_name(path.name + ".gz").exists():
        there = sorted(p.name[5:].split("_")[0] for p in folder.glob("Robot*_Odometry.dat*"))
        raise BadInput(
            f"{folder.name} has no robot {robot}; it has {', '.join(there) or 'none'}. Say which after #, such as #1."
        )
    return read_columns(path, columns, settings.largest_file, tally)


def _moves(odometry: Array, times: Array) -> Iterator[Increment]:
    """Odometry (N, 3) in time order → the move up to each of `times` since the one before, or since row 0."""
    rows: list[list[float]] = odometry.tolist()
    row, now = 0, rows[0][0]
    for stamp in times.tolist():
        moved = Increment()
        while now < stamp:
            last = row + 1 >= len(rows)
            until = stamp if last else min(stamp, rows[row + 1][0])
            moved = moved.then(_rolled(rows[row][1], rows[row][2], until - now))
            now = until
            if not last and now >= rows[row + 1][0]:
                row += 1
        yield moved


def _rolled(speed: float, turn_rate: float, seconds: float) -> Increment:
    """A speed and a turn rate held for a while; the heading in the middle of it gives the direction."""
    if abs(speed) + abs(turn_rate) < STILL:
        return Increment()
    way, turn = speed * seconds, turn_rate * seconds
    gain = control_jacobian(way, turn)
    noise = np.diag([FORWARD_NOISE**2, TURN_NOISE**2]) * seconds
    return Increment(Pose(way * math.cos(turn / 2), way * math.sin(turn / 2), turn), gain @ noise @ gain.T)
