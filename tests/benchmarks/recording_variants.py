"""Recordings made wrong in known ways: `python -m tests.benchmarks.recording_variants [--base NAME] [--only NAME]`.

Each sound drive is written again and again, every time with another defect (units, signs, clocks, frozen scans …),
and goes through `slam_log`. Right is an error of at most twice the sound drive's (0.03 m at least), or a sentence;
wrong is what has neither.
"""

from __future__ import annotations

import argparse
import itertools
import json
import math
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from core.errors import BadInput
from core.geometry import Pose
from core.pipelines.slam import slam_log
from core.recording import ScanRecording, open_log
from core.sensors import Laser
from core.sensors.checks import faults_of
from core.simulation.laser import SimulatedLaser
from core.simulation.world import world_named
from tests.core.recording.log_writers import ODOMETRY, SCAN, TF, two, write_mcap
from tests.core.slam.scan_matching.slipping_wheels import PERIOD_S, slipping_wheels

STRANGERS = Path(__file__).parents[3] / "shared" / "data" / "strangers" / "recordings"
INTEL = Path(__file__).parents[3] / "shared" / "data" / "intel-lab" / "intel.npz"
LASER = Laser(beams=181, angle_min=-math.pi / 2 * 1.33, angle_step=math.radians(1.33), time_step=0.0, rate=5.0)
BEGUN_S = 1.7e9  # Unix time
LEAST_ERROR_M = 0.03


@dataclass(frozen=True)
class Drive:
    """A drive as its devices tell it."""

    name: str
    stamps: np.ndarray  # (N,) [s]
    ranges: np.ndarray  # (N, B) [m]; inf: nothing there
    angles: tuple[float, float]  # of the first beam, from beam to beam [rad]
    range_max: float  # [m]
    times: np.ndarray  # (M,) [s] of the odometry
    poses: np.ndarray  # (M, 3)
    truth: np.ndarray | None = None  # (N, 3) robot poses; None: the sound drive's estimate stands for it
    ahead: float = 0.0  # [m] of the laser before the robot's middle


Making = Callable[[Drive, np.random.Generator], Drive]


def simulated(world: str, seed: int) -> Drive:
    """A drive in a world of the simulator; its wheels slip by a few percent."""
    rng = np.random.default_rng(seed)
    laser, place, rows = SimulatedLaser(LASER, rng), world_named(world), []
    for _, _, truth, rolled in slipping_wheels(rng):
        stamp = PERIOD_S * len(rows)
        scan = laser.scan(place, stamp, np.array([stamp - 1, stamp + 1]), np.tile(truth.vector, (2, 1)))
        rows.append((stamp, scan.ranges, rolled.vector, truth.vector))
    stamps, ranges, poses, true = (np.array(column) for column in zip(*rows, strict=True))
    return Drive(
        f"sim:{world}",
        BEGUN_S + stamps,
        ranges,
        (LASER.angle_min, LASER.angle_step),
        LASER.range_max,
        BEGUN_S + stamps,
        poses,
        true,
    )


def recorded(path: Path, name: str, most: int) -> Drive:
    """The first scans of a log."""
    read = open_log(path)
    assert isinstance(read, ScanRecording) and read.track is not None
    scans = read.scans[:most]
    within = read.track.times <= scans[-1].stamp + 1.0
    track = None
    if path.parent == STRANGERS:
        truth = np.genfromtxt(STRANGERS / "truth.csv", delimiter=",", names=True)
        seconds = np.array([scan.stamp for scan in scans]) - np.floor(scans[0].stamp)
        track = np.column_stack(
            [np.interp(seconds, truth["t_s"], truth[key]) for key in ("x_m", "y_m", "heading_rad")]
        )
    return Drive(
        name,
        np.array([scan.stamp for scan in scans]),
        np.array([scan.ranges for scan in scans]),
        (scans[0].angle_min, scans[0].angle_step),
        scans[0].range_max,
        read.track.times[within],
        read.track.poses[within],
        track,
        read.laser.mounting.x,
    )


BASES: dict[str, Callable[[], Drive]] = {
    "lab": lambda: simulated("lab", 3),
    "floor": lambda: simulated("floor", 5),
    "strangers": lambda: recorded(STRANGERS / "10_short_control.mcap", "strangers", 200),
    "intel": lambda: recorded(INTEL, "intel", 100),
}


def of_poses(change: Callable[[np.ndarray], np.ndarray]) -> Making:
    return lambda drive, _: replace(drive, poses=change(drive.poses.copy()))


def of_headings(change: Callable[[np.ndarray], np.ndarray]) -> Making:
    return lambda drive, _: replace(drive, poses=np.column_stack([drive.poses[:, :2], change(drive.poses[:, 2])]))


def of_ranges(change: Callable[[np.ndarray], np.ndarray], limit: float | None = None) -> Making:
    def make(drive: Drive, _: np.random.Generator) -> Drive:
        return replace(
            drive,
            ranges=np.ascontiguousarray(change(drive.ranges)),
            range_max=drive.range_max * (1.0 if limit is None else limit),
        )

    return make


def by_moves(change: Callable[[Pose], Pose]) -> Making:
    def make(drive: Drive, _: np.random.Generator) -> Drive:
        claimed, made = Pose(), []
        poses = [Pose(*row) for row in drive.poses.tolist()]
        for before, now in itertools.pairwise([poses[0], *poses]):
            claimed = claimed @ change(before.inverse() @ now)
            made.append(claimed.vector)
        return replace(drive, poses=np.array(made))

    return make


def frozen(part: slice) -> Making:
    def make(drive: Drive, _: np.random.Generator) -> Drive:
        ranges, count = drive.ranges.copy(), len(drive.ranges)
        rows = range(*slice(round((part.start or 0) * count), round((part.stop or 1) * count)).indices(count))
        ranges[rows] = ranges[rows[0]]
        return replace(drive, ranges=ranges)

    return make


def frozen_now_and_then(drive: Drive, rng: np.random.Generator) -> Drive:
    """A quarter of the time the driver repeats its last scan."""
    ranges = drive.ranges.copy()
    for number in range(1, len(ranges)):
        if rng.random() < 0.25:
            ranges[number] = ranges[number - 1]
    return replace(drive, ranges=ranges)


def frozen_in_runs(drive: Drive, rng: np.random.Generator) -> Drive:
    """Ten scans of forty are those before."""
    ranges = drive.ranges.copy()
    for start in range(30, len(ranges), 40):
        ranges[start : start + 10] = ranges[start - 1]
    return replace(drive, ranges=ranges)


def as_intensities(drive: Drive, rng: np.random.Generator) -> Drive:
    """Reflectivities 0-255 where the ranges should be."""
    shown = np.nan_to_num(drive.ranges, posinf=drive.range_max, nan=0.0)
    return replace(drive, ranges=np.round(255 / (1 + shown**2) + 10 * rng.random(shown.shape)))


def as_shares(drive: Drive, rng: np.random.Generator) -> Drive:
    """Reflectivities 0-1 where the ranges should be."""
    return replace(drive, ranges=np.round(0.1 + 0.9 * rng.random(drive.ranges.shape), 3))


def as_thousands(drive: Drive, rng: np.random.Generator) -> Drive:
    """Echo strengths of thousands, scattered."""
    return replace(drive, ranges=np.round(1000 + 3000 * rng.random(drive.ranges.shape)))


def two_after_each_other(gap_s: float) -> Making:
    """The drive, and after it another one that begins elsewhere: its second half backwards in space."""

    def make(drive: Drive, _: np.random.Generator) -> Drive:
        lasted = drive.stamps[-1] - drive.stamps[0] + gap_s
        half, middle = len(drive.stamps) // 2, len(drive.times) // 2
        other_poses = np.array(
            [(Pose(*drive.poses[middle]).inverse() @ Pose(*row)).vector for row in drive.poses[middle:].tolist()]
        )
        return replace(
            drive,
            stamps=np.concatenate([drive.stamps[:half], drive.stamps[:half] + lasted]),
            ranges=np.concatenate([drive.ranges[:half], drive.ranges[half : 2 * half]]),
            times=np.concatenate([drive.times[:middle], drive.times[: len(drive.times) - middle] + lasted]),
            poses=np.concatenate([drive.poses[:middle], other_poses]),
            truth=None,
        )

    return make


def written_twice(later: float) -> Making:
    """Every scan comes again so many periods later."""

    def make(drive: Drive, _: np.random.Generator) -> Drive:
        stamps = np.concatenate([drive.stamps, drive.stamps + later * float(np.median(np.diff(drive.stamps)))])
        order = np.argsort(stamps, kind="stable")
        return replace(drive, stamps=stamps[order], ranges=np.concatenate([drive.ranges, drive.ranges])[order])

    return make


VARIANTS: dict[str, Making] = {
    "sound": lambda drive, _: drive,
    "x and y swapped": of_poses(lambda p: p[:, [1, 0, 2]]),
    "x negated": of_poses(lambda p: p * [-1, 1, 1]),
    "y negated": of_poses(lambda p: p * [1, -1, 1]),
    "x and y negated": of_poses(lambda p: p * [-1, -1, 1]),
    "heading negated": of_headings(lambda h: -h),
    "heading from y axis": of_headings(lambda h: h + math.pi / 2),
    "mirrored": of_poses(lambda p: p * [1, -1, -1]),
    "swapped and mirrored": of_poses(lambda p: np.column_stack([p[:, 1], p[:, 0], math.pi / 2 - p[:, 2]])),
    "heading clamped 0..180": of_headings(lambda h: np.clip((h + math.pi) % math.tau - math.pi, 0, math.pi)),
    "heading of 0..360 clamped": of_headings(lambda h: np.clip(h % math.tau, 0, math.pi)),
    "heading modulo 180": of_headings(lambda h: h % math.pi),
    "heading without sign": of_headings(lambda h: np.abs((h + math.pi) % math.tau - math.pi)),
    "heading in half turns": of_headings(lambda h: h / 2),
    "heading stands": of_headings(np.zeros_like),
    "ways x 100": of_poses(lambda p: p * [100, 100, 1]),
    "ways x 0.01": of_poses(lambda p: p * [0.01, 0.01, 1]),
    "ways x 10": of_poses(lambda p: p * [10, 10, 1]),
    "ways x 0.1": of_poses(lambda p: p * [0.1, 0.1, 1]),
    "ways x 1.3": of_poses(lambda p: p * [1.3, 1.3, 1]),
    "odometry in feet": of_poses(lambda p: p * [3.28084, 3.28084, 1]),
    "ranges in km": of_ranges(lambda r: r / 1000),
    "ranges in km, limits too": of_ranges(lambda r: r / 1000, 0.001),
    "ranges in dm": of_ranges(lambda r: r * 10),
    "ranges in dm, limits too": of_ranges(lambda r: r * 10, 10),
    "ranges in feet": of_ranges(lambda r: r * 3.28084),
    "ranges in feet, limits too": of_ranges(lambda r: r * 3.28084, 3.28084),
    "ranges in inches": of_ranges(lambda r: r * 39.37, 39.37),
    "ranges in yards": of_ranges(lambda r: r * 1.0936, 1.0936),
    "ranges in cm": of_ranges(lambda r: r * 100),
    "ranges in mm": of_ranges(lambda r: r * 1000, 1000),
    "ranges in um": of_ranges(lambda r: r * 1e6, 1e6),
    "ranges x 1.1": of_ranges(lambda r: r * 1.1),
    "ranges x 0.9": of_ranges(lambda r: r * 0.9),
    "ranges x 2": of_ranges(lambda r: r * 2, 2),
    "ranges x 0.5": of_ranges(lambda r: r / 2, 0.5),
    "ranges + 0.3 m": of_ranges(lambda r: r + 0.3),
    "frozen scans": frozen(slice(0.0, 1.0)),
    "frozen from the middle": frozen(slice(0.5, 1.0)),
    "frozen for a quarter": frozen(slice(0.4, 0.65)),
    "frozen in runs": frozen_in_runs,
    "frozen now and then": frozen_now_and_then,
    "scans twice, at once": written_twice(0.1),
    "scans twice, later": written_twice(1.5),
    "places by satellite": lambda drive, rng: replace(
        drive, poses=drive.poses + rng.normal(0, 1.0, drive.poses.shape) * [0.3, 0.3, 0]
    ),
    "constant ranges": of_ranges(lambda r: np.full_like(r, 2.0)),
    "constant ranges, noisy": lambda drive, rng: replace(drive, ranges=2.0 + rng.normal(0, 0.01, drive.ranges.shape)),
    "intensities 0-255": as_intensities,
    "intensities 0-1": as_shares,
    "intensities of thousands": as_thousands,
    "reversed beams": of_ranges(lambda r: r[:, ::-1]),
    "two logs": two_after_each_other(30.0),
    "two logs at once": two_after_each_other(0.2),
    "two logs, a day apart": two_after_each_other(86400.0),
    "stamps x 1000": lambda d, _: replace(
        d, stamps=BEGUN_S + 1000 * (d.stamps - d.stamps[0]), times=BEGUN_S + 1000 * (d.times - d.times[0])
    ),
    "stamps / 1000": lambda d, _: replace(
        d, stamps=BEGUN_S + (d.stamps - d.stamps[0]) / 1000, times=BEGUN_S + (d.times - d.times[0]) / 1000
    ),
    "scans' stamps x 1.5": lambda d, _: replace(d, stamps=d.stamps[0] + 1.5 * (d.stamps - d.stamps[0])),
    "scans' stamps x 60": lambda d, _: replace(d, stamps=d.stamps[0] + 60 * (d.stamps - d.stamps[0])),
    "scans late by 1 s": lambda d, _: replace(d, stamps=d.stamps + 1.0),
}


def speeds(times: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Speed ahead and turn rate (M, 2) of poses at times."""
    headings = np.unwrap(poses[:, 2])
    x, y = np.gradient(poses[:, 0], times), np.gradient(poses[:, 1], times)
    return np.column_stack([x * np.cos(headings) + y * np.sin(headings), np.gradient(headings, times)])


def to_mcap(drive: Drive, path: Path, rng: np.random.Generator, shuffled: bool = False) -> Path:
    """Write the drive as messages; the twists are those of the sound wheels."""
    twists = speeds(drive.times, drive.poses)
    told = [
        ("/odom", ODOMETRY, float(t), two.odometry(float(t), row, twist=tuple(twist)))
        for t, row, twist in zip(drive.times, drive.poses.tolist(), twists.tolist(), strict=True)
    ]
    first, step = drive.angles
    told.append(
        ("/tf_static", TF, float(drive.stamps[0]), two.tf(0.0, "base_link", "laser", (drive.ahead, 0.0, 0.0)))
    )
    told += [
        (
            "/scan",
            SCAN,
            float(t),
            two.scan(
                float(t),
                row,
                step=step,
                angle_min=first,
                angle_max=first + step * (len(row) - 1),
                range_max=drive.range_max,
                time_increment=0.0,
            ),
        )
        for t, row in zip(drive.stamps, drive.ranges, strict=True)
    ]
    told.sort(key=lambda one: one[2])
    if shuffled:
        rng.shuffle(told)  # type: ignore[arg-type]
    return write_mcap(path, told)


def to_carmen(drive: Drive, path: Path, rng: np.random.Generator, shuffled: bool = False) -> Path:
    """Write the drive as text: ROBOTLASER1 and ODOM lines."""
    twists = speeds(drive.times, drive.poses)
    header = f"PARAM robot_frontlaser_offset {drive.ahead:.4f}\n"
    lines = [
        (
            float(t),
            "ODOM " + " ".join(f"{v:.6f}" for v in (*row, *twist, 0.0)) + f" {t:.6f} host {t - drive.times[0]:.6f}",
        )
        for t, row, twist in zip(drive.times, drive.poses.tolist(), twists.tolist(), strict=True)
    ]
    first, step = drive.angles
    for t, row in zip(drive.stamps, drive.ranges, strict=True):
        beams = np.nan_to_num(row, nan=0.0, posinf=drive.range_max + 1.0)
        told = " ".join(f"{v:.4f}" for v in beams)
        head = f"RAWLASER1 0 {first:.6f} {step * (len(beams) - 1):.6f} {step:.8f} {drive.range_max:.3f} 0.01 0"
        lines.append(
            (float(t), f"{head} {len(beams)} {told} 0 {t:.6f} host {t - min(drive.stamps[0], drive.times[0]):.6f}")
        )
    lines.sort(key=lambda one: one[0])
    if shuffled:
        rng.shuffle(lines)  # type: ignore[arg-type]
    path.write_text(header + "\n".join(line for _, line in lines) + "\n")
    return path


WRITERS = {"mcap": to_mcap, "log": to_carmen}
VARIANTS_OF_FILES = ("records in random order", "the log twice")


def result(path: Path, truth: np.ndarray | None) -> tuple[float | None, float, list[str], list[str], np.ndarray]:
    """Error [m] to the truth, path [m], codes, other warnings, places by stamp."""
    found = slam_log(path)
    assert isinstance(found.recording, ScanRecording)
    report = found.report
    rows = np.array([(s, p.x, p.y, p.heading) for s, p in zip(found.stamps, found.poses, strict=True)])
    said = {one.sentence for one in report.faults}
    others = [one for one in report.warnings if one not in said]
    error = None if truth is None else apart(rows, truth)
    return error, found.path, [one.code for one in report.faults], others, rows


def apart(rows: np.ndarray, truth: np.ndarray) -> float:
    """Mean distance [m] of places (N, 4: stamp, x, y, heading) and true ones, from the first pose on."""
    start = Pose(*truth[0, 1:4]).inverse()
    true = np.array([(start @ Pose(*row)).vector for row in truth[:, 1:4].tolist()])
    first = Pose(*rows[0, 1:4]).inverse()
    mine = np.array([(first @ Pose(*row)).vector for row in rows[:, 1:4].tolist()])
    when = rows[:, 0] - rows[0, 0]
    at = truth[:, 0] - truth[0, 0]
    wanted = np.column_stack([np.interp(when, at, true[:, k]) for k in (0, 1)])
    return float(np.hypot(*(mine[:, :2] - wanted).T).mean())


def written(name: str, form: str, drive: Drive, folder: Path) -> tuple[Drive, Path]:
    """A variant of a drive in a form, in a folder."""
    rng = np.random.default_rng(11)
    made = VARIANTS[name](drive, rng) if name in VARIANTS else drive
    path = WRITERS[form](made, folder / f"drive.{form}", rng, name == "records in random order")
    if name == "the log twice" and form == "log":
        path.write_text(path.read_text() * 2)
    return made, path


def tried(path: Path, control: float, truth: np.ndarray | None) -> dict[str, object]:
    """Judge a log whose sound form is wrong by `control` [m]; its error is unknown without a truth."""
    try:
        error, way, codes, others, _ = result(path, truth)
    except BadInput as refused:
        return {"verdict": "refused", "codes": [one.code for one in faults_of(refused)], "said": str(refused)[:160]}
    limit = max(2 * control, LEAST_ERROR_M)
    fine = error is not None and error <= limit
    row = {"error": None if error is None else round(error, 3), "path": round(way, 2), "codes": codes, "said": others}
    verdict = "right" if fine and not codes else "named" if codes or others else "right" if fine else "WRONG"
    return row | {"verdict": verdict}


def sound(base: str, form: str, drive: Drive) -> tuple[float, np.ndarray]:
    """Error [m] of the sound drive, and the truth."""
    with tempfile.TemporaryDirectory() as folder:
        path = WRITERS[form](drive, Path(folder) / f"drive.{form}", np.random.default_rng(11), False)
        truth = None if drive.truth is None else np.column_stack([drive.stamps, drive.truth])
        error, _, codes, others, places = result(path, truth)
    sys.stdout.write(f"# {base} {form}: control {error or 0.0:.3f} m {codes} {others}\n")
    return error or 0.0, places if truth is None else truth


def campaign(bases: list[str], forms: list[str], only: list[str]) -> list[dict[str, object]]:
    """Every variant of every base in every form; a row is written as it is known."""
    rows: list[dict[str, object]] = []
    for base, form in itertools.product(bases, forms):
        drive = BASES[base]()
        control, truth = sound(base, form, drive)
        for name in only or [*VARIANTS, *VARIANTS_OF_FILES]:
            with tempfile.TemporaryDirectory() as folder:
                made, path = written(name, form, drive, Path(folder))
                known = truth if made.truth is not None or drive.truth is None else None
                rows.append({"base": base, "form": form, "variant": name} | tried(path, control, known))
            sys.stdout.write(json.dumps(rows[-1]) + "\n")
            sys.stdout.flush()
    return rows


def main() -> None:
    """Print a row for each variant, and how many are wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--base", choices=BASES, action="append")
    parser.add_argument("--form", choices=WRITERS, action="append")
    parser.add_argument("--only", choices=[*VARIANTS, *VARIANTS_OF_FILES], action="append")
    chosen = parser.parse_args()
    rows = campaign(chosen.base or list(BASES), chosen.form or list(WRITERS), chosen.only or [])
    wrong = [row for row in rows if row["verdict"] == "WRONG"]
    sys.stdout.write(f"{len(rows)} variants, {len(wrong)} wrong and silent\n")


if __name__ == "__main__":
    main()
