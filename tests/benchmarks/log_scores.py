"""How well the landmark filter did on a log of sightings, by the truth that lies beside the log.

The filter never sees any of it: the truth is read here, for scoring alone. The start is the world's origin for the
filter; the truth's first pose carries its path over.
"""

import time
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from core.geometry import Pose
from core.message import Array
from core.recording import Ids, SightingRecording, open_log
from core.slam.ekf_slam import EkfSettings, EkfSlam

CORRIDOR, PARK = "corridor-loop/corridor.npz", "victoria-park/victoria_park.txt.gz"
ROBOTS = tuple(f"mrclam6#{robot}" for robot in range(1, 6))


@dataclass(frozen=True)
class Score:
    """A run through one log."""

    error: float  # [m] RMSE of the position over all updates; for mrclam6 after the best turn and shift
    worst: float  # [m] of one update
    landmarks: int  # past their probation, at the end
    nees: float  # mean over the updates, ideal 3
    update: float  # [ms] processor time, mean


def score(data: Path, log: str, ids: Ids, settings: EkfSettings | None = None, updates: int | None = None) -> Score:
    """Drive the filter through a log below the folder `data`, or its first `updates`, and compare."""
    recording = open_log(data / log, ids=ids)
    assert isinstance(recording, SightingRecording)
    truths, start = true_poses(data, log, recording)
    slam, squared, found = EkfSlam(settings), [], []
    began = time.process_time()
    for step, truth in islice(zip(recording, truths, strict=True), updates):
        slam.advance(step.increment)
        slam.see(step.sightings)
        found.append(slam.estimate.pose)
        squared.append(slam.nees(start.inverse() @ truth))
    spent = time.process_time() - began
    estimated = start.apply(np.array([(pose.x, pose.y) for pose in found]))
    true = np.array([(pose.x, pose.y) for pose in truths[:updates]])
    if log.startswith("mrclam6"):
        estimated = aligned(estimated, true)
    errors = np.hypot(*(estimated - true).T)
    return Score(
        error=float(np.sqrt((errors**2).mean())),
        worst=float(errors.max()),
        landmarks=len(slam.landmarks),
        nees=float(np.nanmean(squared)),
        update=1e3 * spent / len(found),
    )


def true_poses(data: Path, log: str, recording: SightingRecording) -> tuple[list[Pose], Pose]:
    """The true pose at every step, and where the robot stood when the log began."""
    stamps = np.array([step.stamp for step in recording])
    folder, _, robot = log.partition("#")
    if folder == "mrclam6":
        begin = np.loadtxt(data / folder / f"Robot{robot}_Odometry.dat.gz")[0, 0]
        captured = np.loadtxt(data / folder / f"Robot{robot}_Groundtruth.dat.gz")
        captured[:, 3] = np.unwrap(captured[:, 3])
        at = np.column_stack([np.interp([begin, *stamps], captured[:, 0], captured[:, k]) for k in (1, 2, 3)])
        return poses(at[1:]), Pose(*at[0].tolist())
    if log == CORRIDOR:
        truth = np.load(data / log)["truth"]
        return poses(truth[np.round(stamps * 5).astype(int)]), Pose(*truth[0].tolist())
    reference = np.loadtxt(data / "victoria-park" / "batch_map_poses.csv.gz", delimiter=",")
    return poses(np.vstack((np.zeros(3), reference))[stamps.astype(int)]), Pose()


def poses(rows: Array) -> list[Pose]:
    """Rows (N, 3) of x, y [m] and heading [rad] → poses."""
    return [Pose(*row) for row in rows.tolist()]


def aligned(points: Array, onto: Array) -> Array:
    """Points (N, 2) turned and shifted as a whole to lie as near as possible to others (N, 2)."""
    off, target = points - points.mean(axis=0), onto - onto.mean(axis=0)
    left, _, right = np.linalg.svd(off.T @ target)
    turn = left @ np.diag([1.0, np.sign(np.linalg.det(left @ right))]) @ right
    return off @ turn + onto.mean(axis=0)
