"""Folders in the MRCLAM form: `Barcodes.dat`, `RobotK_Odometry.dat`, `RobotK_Measurement.dat`, plain or gzip'ed.

Odometry: time, speed [m/s], turn rate [rad/s], held until the next. Measurement: time, BARCODE, range [m], bearing
[rad]. Barcodes: subject, barcode; subjects 1-5 are robots.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from core.errors import BadInput
from core.geometry import Pose
from core.log.columns import read_columns
from core.log.motion import Motion
from core.log.recording import LogSettings, SightingRecording, SightingStep
from core.log.sightings import Ids, grouped, seen_in, sighting_recording
from core.log.tally import Tally
from core.message import Array

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
    steps = [
        SightingStep(
            stamp=float(stamp), motion=moved, motion_covariance=covariance, seen=seen_in(by_time[n], ids, tally)
        )
        for n, (stamp, (moved, covariance)) in enumerate(zip(times, _motions(odometry, times), strict=True))
    ]
    tally.topics = [f"Robot{robot}_Odometry: odometry", f"Robot{robot}_Measurement: sightings"]
    return sighting_recording(folder, steps, SIGHTING_NOISE, tally, "MRCLAM folder")


def _robot_file(folder: Path, robot: int, what: str, columns: int, settings: LogSettings, tally: Tally) -> Array:
    path = folder / f"Robot{robot}_{what}.dat"
    if not path.exists() and not path.with_name(path.name + ".gz").exists():
        there = sorted(p.name[5:].split("_")[0] for p in folder.glob("Robot*_Odometry.dat*"))
        raise BadInput(
            f"{folder.name} has no robot {robot}; it has {', '.join(there) or 'none'}. Say which after #, such as #1."
        )
    return read_columns(path, columns, settings.largest_file, tally)


def _motions(odometry: Array, times: Array) -> list[tuple[Pose, Array]]:
    """Odometry (N, 3) in time order → the motion up to each of `times` since the one before, or since row 0."""
    motions: list[tuple[Pose, Array]] = []
    motion = Motion()
    rows: list[list[float]] = odometry.tolist()
    row, now = 0, rows[0][0]
    for stamp in times.tolist():
        while now < stamp:
            until = min(stamp, rows[row + 1][0]) if row + 1 < len(rows) else stamp
            _roll(motion, rows[row][1], rows[row][2], until - now)
            now = until
            if row + 1 < len(rows) and now >= rows[row + 1][0]:
                row += 1
        motions.append(motion.take())
    return motions


def _roll(motion: Motion, speed: float, turn_rate: float, seconds: float) -> None:
    """Hold a speed and a turn rate; the heading in the middle of the step gives its direction."""
    if abs(speed) + abs(turn_rate) < STILL:
        return
    way, turn = speed * seconds, turn_rate * seconds
    c, s = math.cos(turn / 2), math.sin(turn / 2)
    gain = np.array([[c, -way * s / 2], [s, way * c / 2], [0.0, 1.0]])
    noise = np.diag([FORWARD_NOISE**2, TURN_NOISE**2]) * seconds
    motion.add(Pose(way * c, way * s, turn), gain @ noise @ gain.T)
