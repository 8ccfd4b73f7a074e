"""Whether the filter stays as sure as it should be over 1.2 km: `python -m tests.benchmarks.consistency [--runs 12]`.

Two laps of 624 m among 35 landmarks, identities given, with the parameters of Bailey's well-known simulator (3 m/s,
wheelbase 4 m). The true vehicle does what is commanded; the filter hears noisy controls and sightings. Run r always
draws the same. NEES of the pose, as the filter's own covariance measures errors; ideal 3. The
paper's form is the plain EKF.
"""

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import islice

import numpy as np

from core.geometry import Pose, wrap
from core.message import Array
from core.perception.landmarks.landmarks import Sighting
from core.slam.ekf_slam import EkfSettings, EkfSlam
from core.slam.motion import Increment, MotionSettings, steered
from tests.benchmarks.command import run_command

MOTION = MotionSettings(wheelbase=4.0, speed_sd=0.3, steer_sd=math.radians(3), cruise=3.0, step=0.025)
EVERY = 8  # control steps between sightings
MOST_STEER, STEER_RATE = math.radians(30), math.radians(20)  # [rad], [rad/s]
REACHED = 1.0  # [m] from a waypoint, the next one is steered for
RADIUS = 100.0  # [m] of a lap
NOISE = np.diag([0.1**2, math.radians(1) ** 2])
SIGHT, HALF_FIELD = 30.0, math.radians(90)  # [m], [rad]
LAPS, WAYPOINTS, LANDMARKS = 2, 16, 35


@dataclass(frozen=True)
class Step:
    """One update: the move heard since the last, what was sighted, and where the vehicle is."""

    increment: Increment
    sightings: tuple[Sighting, ...]
    truth: Pose


@cache
def landmarks() -> Array:
    """The map (35, 2) [m]."""
    rng = np.random.default_rng(LANDMARKS)
    around = rng.uniform(0, 2 * np.pi, LANDMARKS)
    reach = RADIUS + rng.uniform(-25, 25, LANDMARKS)
    return np.column_stack((reach * np.sin(around), RADIUS - reach * np.cos(around)))


@cache
def drive() -> tuple[tuple[float, ...], tuple[Pose, ...]]:
    """The steering angles [rad] commanded, and the poses they lead to, one more."""
    angles = 2 * np.pi * np.arange(1, WAYPOINTS + 1) / WAYPOINTS
    lap = np.column_stack((RADIUS * np.sin(angles), RADIUS - RADIUS * np.cos(angles))).tolist()
    pose, steer, steers, poses = Pose(), 0.0, [], [Pose()]
    for x, y in lap * LAPS:
        while pose.distance_to(x, y) >= REACHED:
            change = wrap(pose.bearing_to(x, y) - steer)
            steer += min(max(change, -STEER_RATE * MOTION.step), STEER_RATE * MOTION.step)
            steer = min(max(steer, -MOST_STEER), MOST_STEER)
            pose = pose @ steered(MOTION.cruise, steer, MOTION.step, MOTION).pose
            steers.append(steer)
            poses.append(pose)
    return tuple(steers), tuple(poses)


def heard(run: int, motion: MotionSettings = MOTION) -> Iterator[Step]:
    """What the filter is told in run `run` (0, 1, …), with the noise of `motion`."""
    rng = np.random.default_rng(run)
    steers, poses = drive()
    places, moved = landmarks(), Increment()
    for number, (steer, pose) in enumerate(zip(steers, poses[1:], strict=True), 1):
        speed = motion.cruise + motion.speed_sd * rng.standard_normal()
        moved = moved.then(steered(speed, steer + motion.steer_sd * rng.standard_normal(), motion.step, motion))
        if number % EVERY:
            continue
        seen: list[Sighting] = []
        for name, (x, y) in enumerate(places.tolist()):
            reach, bearing = pose.distance_to(x, y), pose.bearing_to(x, y)
            if reach < SIGHT and abs(bearing) < HALF_FIELD:
                reach += 0.1 * rng.standard_normal()
                bearing = wrap(bearing + math.radians(1) * rng.standard_normal())
                seen.append(Sighting(range=reach, bearing=bearing, covariance=NOISE, id=name))
        yield Step(moved, tuple(seen), pose)
        moved = Increment()


def run_filter(
    run: int, mode: str, motion: MotionSettings = MOTION, updates: int | None = None
) -> tuple[Array, Array]:
    """One run, or its first updates → NEES (K,) and position errors (K,) [m] after every update."""
    slam = EkfSlam(EkfSettings(mode="paper" if mode == "paper" else "invariant"))
    squared: list[float] = []
    errors: list[float] = []
    for step in islice(heard(run, motion), updates):
        slam.advance(step.increment)
        slam.see(step.sightings)
        squared.append(slam.nees(step.truth))
        errors.append(slam.filter.pose.distance_to(step.truth.x, step.truth.y))
    return np.array(squared), np.array(errors)


def campaign(runs: int, times: float) -> dict[str, dict[str, float]]:
    """Both forms over so many runs, controls `times` as noisy → their figures."""
    motion = MotionSettings(
        wheelbase=4.0, speed_sd=0.3 * times, steer_sd=math.radians(3) * times, cruise=3.0, step=0.025
    )
    found: dict[str, dict[str, float]] = {}
    for mode in ("invariant", "paper"):
        began = time.process_time()
        squared, errors = zip(*(run_filter(run, mode, motion) for run in range(runs)), strict=True)
        table, off = np.array(squared), np.array(errors)
        last = table[:, -table.shape[1] // 4 :]
        found[mode] = {
            "nees_mean": round(float(table.mean()), 2),
            "nees_last_quarter": round(float(last.mean()), 2),
            "error_mean_m": round(float(off.mean()), 2),
            "error_worst_run_m": round(float(off.mean(axis=1).max()), 2),
            "seconds_per_run": round((time.process_time() - began) / runs, 1),
        }
    return found


def main(*, runs: int = 12) -> object:
    return {f"controls {times:g} times as noisy": campaign(runs, times) for times in (1.0, 2.0)}


if __name__ == "__main__":
    run_command(main)
