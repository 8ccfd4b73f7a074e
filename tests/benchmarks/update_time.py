"""Time of an update with six sightings on one core: `OMP_NUM_THREADS=1 python -m tests.benchmarks.update_time`.

A field of N landmarks, all in the map; the robot drives through it and sights the six nearest. Ours includes the
association of unnamed sightings, prediction, misses, doubles and the figures for the operator. Beside it the
textbook's EKF in numpy, (I - KH)P sighting by sighting and the identities given to it, and MRPT's kf-slam in both its
ways, with the same sightings unnamed, where it is installed. Processor time for ours and the textbook's; for MRPT the
time from one of its answers to the next, told by itself to 0.1 ms: so let nothing else run.
"""

import json
import math
import subprocess
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from core.geometry import Pose, rotation, wrap
from core.message import Array
from core.perception.landmarks.landmarks import Sighting
from core.slam.ekf_slam import EkfSettings, EkfSlam
from core.slam.motion import Increment
from tests.benchmarks import mrpt
from tests.benchmarks.command import print_row, run_command

SIZES = (100, 500, 1000)
SEEN = 6  # sightings per update
SPACING = 2.9  # [m] between landmarks
SDS = (0.02, math.radians(0.1))  # [m], [rad]
NOISE = np.diag(np.square(SDS))
STEP = Increment(Pose(0.1, 0.0, 0.02), np.diag([1e-5, 1e-6, 1e-5]))
TARGETS = {100: 0.3, 500: 1.2, 1000: 4.0}  # [ms]


@dataclass(frozen=True)
class Drive:
    """A robot among N landmarks: first it sights them all, then six at a time."""

    first: Array  # (N, 3) identity, range [m], bearing [rad]
    steps: tuple[Array, ...]  # each (6, 3)
    reach: float  # [m] within which the six lie


def drive(count: int, updates: int) -> Drive:
    """A drive of so many updates among `count` landmarks."""
    rng, side = np.random.default_rng(count), math.ceil(math.sqrt(count))
    grid = np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(-1, 2)[:count]
    places = SPACING * (grid - 0.5 * side + rng.uniform(0.2, 0.8, grid.shape))
    rows, pose, reach = [_sight(Pose(), places, np.arange(count), rng)], Pose(), 0.0
    for _ in range(updates):
        pose = pose @ STEP.pose
        reaches = np.hypot(*(places - (pose.x, pose.y)).T)
        nearest = np.argsort(reaches)[:SEEN]
        reach = max(reach, float(reaches[nearest].max()))
        rows.append(_sight(pose, places, nearest, rng))
    return Drive(rows[0], tuple(rows[1:]), reach)


def _sight(pose: Pose, places: Array, names: Array, rng: np.random.Generator) -> Array:
    seen = pose.inverse().apply(places[names])
    noise = rng.normal(size=seen.shape) * SDS
    return np.column_stack((names, np.hypot(*seen.T) + noise[:, 0], np.arctan2(*seen.T[::-1]) + noise[:, 1]))


def ours(told: Drive) -> list[float]:
    """Seconds of every update of our filter, landmarks past their probation from the start."""
    slam = EkfSlam(EkfSettings(at_once=len(told.first) + 1))
    slam.see(_unnamed(told.first))
    spent: list[float] = []
    for rows in told.steps:
        seen = _unnamed(rows)
        began = time.process_time()
        slam.advance(STEP)
        slam.see(seen)
        spent.append(time.process_time() - began)
        assert slam.health.matched == SEEN, "a sighting found no landmark: this would not be the time of an update"
    return spent


def _unnamed(rows: Array) -> list[Sighting]:
    return [Sighting(range=r, bearing=wrap(b), covariance=NOISE) for _, r, b in rows.tolist()]


def textbook(told: Drive) -> list[float]:
    """Seconds of every update as textbooks write it: dense matrices, sighting by sighting."""
    size = 3 + 2 * len(told.first)
    state, spread = np.zeros(size), np.zeros((size, size))
    for name, reach, bearing in told.first.tolist():
        first = 3 + 2 * int(name)
        c, s = math.cos(bearing), math.sin(bearing)
        state[first : first + 2] = reach * c, reach * s
        slope = np.array([[c, -reach * s], [s, reach * c]])
        spread[first : first + 2, first : first + 2] = slope @ NOISE @ slope.T
    spent: list[float] = []
    for rows in told.steps:
        began = time.process_time()
        state, spread = _predicted(state, spread)
        for name, reach, bearing in rows.tolist():
            state, spread = _corrected(state, spread, 3 + 2 * int(name), np.array([reach, bearing]))
        spent.append(time.process_time() - began)
    return spent


def _predicted(state: Array, spread: Array) -> tuple[Array, Array]:
    moved = rotation(state[2]) @ (STEP.pose.x, STEP.pose.y)
    slope, onto = np.eye(len(state)), np.eye(3)
    slope[0, 2], slope[1, 2] = -moved[1], moved[0]
    onto[:2, :2] = rotation(state[2])
    state = state.copy()
    state[:3] += moved[0], moved[1], STEP.pose.heading
    spread = slope @ spread @ slope.T
    spread[:3, :3] += onto @ STEP.covariance @ onto.T
    return state, spread


def _corrected(state: Array, spread: Array, first: int, sighting: Array) -> tuple[Array, Array]:
    dx, dy = state[first : first + 2] - state[:2]
    q = dx * dx + dy * dy
    r = math.sqrt(q)
    slope = np.zeros((2, len(state)))
    slope[:, :3] = [[-dx / r, -dy / r, 0.0], [dy / q, -dx / q, -1.0]]
    slope[:, first : first + 2] = [[dx / r, dy / r], [-dy / q, dx / q]]
    off = sighting - (r, math.atan2(dy, dx) - state[2])
    off[1] = wrap(float(off[1]))
    gain = spread @ slope.T @ np.linalg.inv(slope @ spread @ slope.T + NOISE)
    return state + gain @ off, (np.eye(len(state)) - gain @ slope) @ spread


def peer(told: Drive, method: str, limit: float) -> list[float]:
    """Seconds of every update of kf-slam but the first, in which it takes in the whole map."""
    none = np.zeros((3, 3))
    steps = [mrpt.Seen(Pose(), none, _nameless(told.first), float(told.first[:, 1].max()) + 1.0, math.pi)]
    steps += [
        mrpt.Seen(STEP.pose, STEP.covariance, _nameless(rows), told.reach + 0.1, math.pi) for rows in told.steps
    ]
    with tempfile.TemporaryDirectory() as folder:
        return mrpt.run(steps, Path(folder), SDS, method, limit).seconds[2:].tolist()


def _nameless(rows: Array) -> Array:
    return np.column_stack((np.full(len(rows), mrpt.NOBODY), rows[:, 1], (rows[:, 2] + np.pi) % (2 * np.pi) - np.pi))


def median_ms(spent: list[float]) -> float:
    """Median [ms]."""
    return round(1000 * float(np.median(spent)), 3)


def main(
    *,
    sizes: Sequence[int] = tuple(SIZES),
    updates: int = 100,
    alone: bool = False,  # without MRPT and textbook
    limit: float = 120.0,  # [s] that MRPT may take for one size
) -> None:
    for size in sizes:
        told = drive(size, updates)
        row: dict[str, float | str | None] = {"ours_ms": median_ms(ours(told)), "target_ms": TARGETS.get(size)}
        if not alone:
            few = Drive(told.first, told.steps[: 40 if size < 300 else 6], told.reach)
            row["textbook_ms"] = median_ms(textbook(few))
            for name, method in (("mrpt_ms", "kfEKFNaive"), ("mrpt_by_numbers_ms", "kfEKFAlaDavison")):
                try:
                    row[name] = median_ms(peer(few, method, limit)) if mrpt.installed() else None
                except subprocess.TimeoutExpired:
                    row[name] = f"not done after {limit:.0f} s"
        print_row(f"N = {size}: {json.dumps(row)}")
    if not alone and not mrpt.installed():
        print_row(mrpt.ABSENT)


if __name__ == "__main__":
    run_command(main)
