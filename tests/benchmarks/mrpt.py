"""MRPT's kf-slam on our sightings: its recording form, its settings, its answers. `apt-get install mrpt-apps`.

Version 2.5.8 was measured. A rawlog is a gzip'ed row of objects: length of the class name with the highest bit set,
the name, the version of its layout, its fields in little-endian order, and an end mark.
"""

import gzip
import math
import re
import shutil
import struct
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from core.geometry import Pose
from core.message import Array

PROGRAM = "kf-slam"
ABSENT = "MRPT's kf-slam is not installed here (Debian: apt-get install mrpt-apps); its columns stay empty."
END = b"\x88"
NOBODY = -1  # the identity of a sighting that has none
EPOCH = 132_500_000_000_000_000  # its clock counts 100 ns since 1601
SETTINGS = """
[MappingApplication]
kf_implementation = CRangeBearingKFSLAM2D
logOutput_dir = {out}
SAVE_LOG_FREQUENCY = 1000000
SAVE_DA_LOG = false
SAVE_3D_SCENES = false
SAVE_MAP_REPRESENTATIONS = false
SHOW_3D_LIVE = false
[RangeBearingKFSLAM_KalmanFilter]
method = {method}
[RangeBearingKFSLAM]
std_sensor_range = {range_sd}
std_sensor_yaw_deg = {bearing_sd_deg}
"""
STAMP = re.compile(r"^\[(\d+):(\d+):(\d+\.\d+)\|INFO")
PLACE = re.compile(r"Mean pose: \((\S+),(\S+),(\S+)deg\)")  # to the millimetre
COUNT = re.compile(r"# of landmarks in the map: (\d+)")


@dataclass(frozen=True)
class Seen:
    """One step: the move since the step before with its covariance (3, 3), then rows (M, 3) of id, range, bearing."""

    move: Pose
    covariance: Array
    rows: Array
    reach: float  # [m] the sensor's range
    half_field: float  # [rad] half its field of view


@dataclass(frozen=True)
class Answer:
    """What kf-slam made of a log."""

    poses: Array  # (K, 3) x, y, heading after every step
    landmarks: Array  # (K,) in the map after every step
    seconds: Array  # (K,) [s] from the answer before to this one; the first is not a number


def installed() -> bool:
    """Whether the program is here."""
    return shutil.which(PROGRAM) is not None


def run(
    steps: Iterable[Seen], folder: Path, noise: tuple[float, float], method: str = "kfEKFNaive", limit: float = 600.0
) -> Answer:
    """Steps through kf-slam, `noise` sd of range [m] and bearing [rad], at most `limit` [s] → its answers.

    `method`: kfEKFNaive (its default) or kfEKFAlaDavison (number by number). Raises RuntimeError with its last words
    where it breaks, subprocess.TimeoutExpired where it takes too long.
    """
    log, told = folder / "steps.rawlog", folder / "kf-slam.ini"
    with gzip.open(log, "wb", compresslevel=1) as file:
        for number, step in enumerate(steps):
            file.write(_action(step, number))
            file.write(_frame(step, number))
    told.write_text(
        SETTINGS.format(out=folder / "out", method=method, range_sd=noise[0], bearing_sd_deg=math.degrees(noise[1]))
    )
    ended = subprocess.run(
        [PROGRAM, str(told), str(log)],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=limit,
        cwd=folder,
        check=False,
    )
    answer = _read(ended.stdout + ended.stderr)
    if not len(answer.poses):
        raise RuntimeError(f"kf-slam gave no answer: {ended.stderr[-300:] or ended.stdout[-300:]}")
    return answer


def _read(words: str) -> Answer:
    poses: list[tuple[float, float, float]] = []
    counts: list[int] = []
    stamps: list[float] = []
    for line in words.splitlines():
        place, count, stamp = PLACE.search(line), COUNT.search(line), STAMP.search(line)
        if place and stamp:
            x, y, heading = (float(number) for number in place.groups())
            poses.append((x, y, math.radians(heading)))
            hours, minutes, seconds = (float(number) for number in stamp.groups())
            stamps.append(3600 * hours + 60 * minutes + seconds)
        elif count:
            counts.append(int(count[1]))
    seconds = np.concatenate(([math.nan], np.diff(stamps) % 86400)) if stamps else np.zeros(0)
    return Answer(np.array(poses).reshape(-1, 3), np.array(counts), seconds)


def _object(name: str, version: int, fields: bytes) -> bytes:
    return bytes([0x80 | len(name)]) + name.encode() + bytes([version]) + fields + END


def _action(step: Seen, number: int) -> bytes:
    """The move, as a Gaussian with its own covariance."""
    mean = _object("mrpt::poses::CPose2D", 1, struct.pack("<3d", step.move.x, step.move.y, step.move.heading))
    c = step.covariance
    spread = struct.pack("<6d", c[0, 0], c[1, 1], c[2, 2], c[0, 1], c[0, 2], c[1, 2])
    gaussian = _object("mrpt::poses::CPosePDFGaussian", 2, mean + spread)
    by_matching, no_velocities, no_encoders = 1, False, False
    moved = struct.pack("<I", by_matching) + gaussian + struct.pack("<2?Q", no_velocities, no_encoders, _time(number))
    one = _object("mrpt::obs::CActionRobotMovement2D", 7, moved)
    return _object("mrpt::obs::CActionCollection", 0, struct.pack("<I", 1) + one)


def _frame(step: Seen, number: int) -> bytes:
    """The sightings; the sensor stands at the robot's origin."""
    mounting = _object("mrpt::poses::CPose3D", 3, struct.pack("<12d", 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1))
    fields = struct.pack("<4f", 0.0, step.reach, 2 * step.half_field, 0.1) + mounting
    fields += struct.pack("<Q?3f", _time(number), False, 0.0, 0.0, 0.0) + struct.pack("<I", len(step.rows))
    for name, reach, bearing in step.rows.tolist():
        fields += struct.pack("<3fi", reach, bearing, 0.0, int(name))
    seen = _object("mrpt::obs::CObservationBearingRange", 3, fields + struct.pack("<I", 0))
    return _object("mrpt::obs::CSensoryFrame", 2, struct.pack("<I", 1) + seen)


def _time(number: int) -> int:
    return EPOCH + 2_000_000 * number
