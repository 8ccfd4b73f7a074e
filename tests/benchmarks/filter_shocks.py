"""The filter after shocks, drawn from fixed seeds: `python -m tests.benchmarks.filter_shocks [--runs 20]`.

A robot drives round and round a hall of 12 x 8 m with corners on its walls and pillars, at 0.3 m/s and 5 Hz, the
identities given. After a minute comes the shock: for five seconds every fifth sighting bears the name of another
landmark in view, or within a second the wheels tell of a metre that was not driven, or the robot is turned and
pushed unnoticed. "Back" is when the pose error stays under 3 sigma for the rest of the run (NEES(3) below 14.2 in all
but the share of instants that a consistent filter has too); then, how far any landmark moved that was known before.
"""

import json
import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from core.geometry import Pose, arc, wrap
from core.message import Array
from core.perception.landmarks.landmarks import Sighting
from core.slam.ekf_slam import EkfSettings, EkfSlam
from core.slam.motion import Increment, MotionSettings, rolled
from tests.benchmarks.command import print_row, run_command

PERIOD, SPEED, RADIUS = 0.2, 0.3, 2.5  # [s], [m/s], [m]
WARM_UP, AFTER = 60.0, 40.0  # [s]
SDS = (0.02, math.radians(0.5))  # [m], [rad]
NOISE = np.diag(np.square(SDS))
MOTION = MotionSettings()
SIGHT, HALF_FIELD = 5.0, math.radians(120)
BOUND = 14.16  # chi-square, 3 degrees of freedom: within 3 sigma
RARE = 0.03  # share of instants outside that says nothing
HALL = np.array(
    [(x, y) for x in (-6, -3, 0, 3, 6) for y in (-4, 4)]
    + [(x, y) for x in (-6, 6) for y in (-1.3, 1.3)]
    + [(-0.3, -0.3), (0.3, -0.3), (0.3, 0.3), (-0.3, 0.3), (4.2, 1.0), (4.6, 1.0), (-4.2, -1.0), (-4.6, -1.0)]
)  # (22, 2) [m]
Shock = Callable[[int, float], "Blow"]


@dataclass(frozen=True)
class Blow:
    """What is wrong with one step."""

    told: float = 0.0  # [m] that the wheels tell beyond what was driven
    unnoticed: Pose = field(default_factory=Pose)  # a move that nobody tells of
    misnamed: float = 0.0  # share of sightings that bear another name


@dataclass(frozen=True)
class Outcome:
    back: float  # [s] after the shock's end until under 3 sigma for good; infinite: never
    worst: float  # [m] of the pose from ten seconds after on
    moved: float  # [m] that a landmark known before moved at most, ten seconds after
    shock: float  # [m] of the pose, at most
    noticed: int  # updates that were taken for a slip


def none(step: int, since: float) -> Blow:
    """All is well."""
    return Blow()


def names(step: int, since: float) -> Blow:
    """Every fifth sighting is someone else's for five seconds."""
    return Blow(misnamed=0.2 if 0 <= since < 5 else 0.0)


def slip(step: int, since: float) -> Blow:
    """The wheels spin: within a second they tell a metre too much."""
    return Blow(told=PERIOD if 0 <= since < 1 - 1e-9 else 0.0)


def push(step: int, since: float) -> Blow:
    """A person pushes the robot by a metre and turns it by half a right angle, at once."""
    return Blow(unnoticed=Pose(-0.6, 0.8, math.radians(45)) if 0 <= since < PERIOD - 1e-9 else Pose())


SHOCKS: dict[str, tuple[Shock, float]] = {
    "none": (none, 0.0),
    "names": (names, 5.0),
    "slip": (slip, 1.0),
    "push": (push, 0.2),
}


def run(shock: str, seed: int, settings: EkfSettings | None = None) -> Outcome:
    blow_at, lasts = SHOCKS[shock]
    rng, slam = np.random.default_rng(seed), EkfSlam(settings)
    pose = Pose(0.0, -RADIUS, 0.0)
    start, before = pose, np.zeros((0, 2))
    squared: list[float] = []
    errors: list[float] = []
    moved, noticed = 0.0, 0
    for step in range(round((WARM_UP + AFTER + lasts) / PERIOD)):
        since = step * PERIOD - WARM_UP
        blow = blow_at(step, since)
        if abs(since) < 1e-9:
            before = np.array([mark.position for mark in slam.landmarks])
        driven = arc(SPEED * PERIOD, SPEED * PERIOD / RADIUS)
        pose = pose @ driven @ blow.unnoticed
        slam.advance(_heard(driven, blow.told, rng))
        slam.see(_sighted(pose, blow.misnamed, rng))
        truth = start.inverse() @ pose
        squared.append(slam.nees(truth))
        errors.append(slam.filter.pose.distance_to(truth.x, truth.y))
        noticed += slam.health.slipping
        if since - lasts >= 10 and len(before):
            now = np.array([mark.position for mark in slam.landmarks[: len(before)]])
            moved = max(moved, float(np.hypot(*(now - before).T).max()))
    over = round((WARM_UP + lasts) / PERIOD)
    return Outcome(
        back=_back(np.array(squared[over:])),
        worst=max(errors[over + round(10 / PERIOD) :]),
        moved=moved,
        shock=max(errors[round(WARM_UP / PERIOD) :]),
        noticed=noticed,
    )


def _back(squared: Array) -> float:
    """NEES (K,) since the shock's end → [s] until no more of it lies outside than luck explains."""
    outside = squared > BOUND
    left = np.cumsum(outside[::-1])[::-1] / np.arange(len(outside), 0, -1)
    calm = np.flatnonzero((left <= RARE) & ~outside)
    return PERIOD * float(calm[0]) if len(calm) else math.inf


def _heard(driven: Pose, too_much: float, rng: np.random.Generator) -> Increment:
    """What the wheels tell of a step."""
    claimed = rolled(arc(driven.x + too_much, driven.heading), PERIOD, MOTION)
    true = rolled(driven, PERIOD, MOTION)
    values, vectors = np.linalg.eigh(true.covariance)
    noise = vectors @ (np.sqrt(np.maximum(values, 0.0)) * rng.normal(size=3))
    pose = claimed.pose
    return Increment(Pose(*(pose.vector + noise).tolist()), claimed.covariance)


def _sighted(pose: Pose, misnamed: float, rng: np.random.Generator) -> list[Sighting]:
    """What the robot sights of the hall; a share of it under the name of another landmark in view."""
    seen = pose.inverse().apply(HALL)
    reach, bearing = np.hypot(*seen.T), np.arctan2(seen[:, 1], seen[:, 0])
    visible = np.flatnonzero((reach < SIGHT) & (np.abs(bearing) < HALF_FIELD))
    told: list[Sighting] = []
    for name in visible.tolist():
        called = name
        if rng.random() < misnamed:
            called = int(rng.choice(visible[visible != name]))
        if any(other.id == called for other in told):
            continue  # one name, one sighting
        off = rng.normal(size=2) * SDS
        told.append(
            Sighting(
                range=float(reach[name] + off[0]),
                bearing=wrap(float(bearing[name] + off[1])),
                covariance=NOISE,
                id=called,
            )
        )
    return told


def main(*, runs: int = 20) -> None:
    for name in SHOCKS:
        outcomes = [run(name, seed) for seed in range(runs)]
        row = {
            "runs": runs,
            "back_within_10_s": sum(one.back <= 10 for one in outcomes),
            "back_worst_s": max(one.back for one in outcomes),
            "error_at_most_m": round(max(one.shock for one in outcomes), 3),
            "error_after_10_s_worst_m": round(max(one.worst for one in outcomes), 3),
            "landmark_moved_worst_m": round(max(one.moved for one in outcomes), 3),
            "taken_for_a_slip": sum(one.noticed for one in outcomes),
        }
        print_row(f"{name}: {json.dumps(row)}")


if __name__ == "__main__":
    run_command(main)
