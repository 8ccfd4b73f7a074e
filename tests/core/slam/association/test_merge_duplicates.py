"""A long loop with one sighting a scan: when it closes, the robot is unsure by more than the way between trees."""

import math

import numpy as np
import pytest

from core.geometry import Pose
from core.perception.landmarks.landmarks import Sighting
from core.slam.ekf.invariant import InvariantFilter
from core.slam.ekf_slam import EkfSettings, EkfSlam
from core.slam.motion import Increment

RADIUS, SIGHT, TREES = 40.0, 14.0, 48
NOISE = np.diag([0.2**2, math.radians(1.0) ** 2])
STEP = Increment(Pose(0.5, 0.0, 0.5 / RADIUS), np.diag([0.01**2, 0.01**2, 0.012**2]))
LAP = round(2 * math.pi * RADIUS / 0.5)


def park(rng: np.random.Generator) -> np.ndarray:
    """Trees on both sides of a round way that begins at the origin."""
    around = 2 * math.pi * (np.arange(TREES) + rng.uniform(-0.4, 0.4, TREES)) / TREES
    away = RADIUS + rng.choice((-1, 1), TREES) * rng.uniform(3.0, 9.0, TREES)
    return np.column_stack((away * np.sin(around), RADIUS - away * np.cos(around)))


def driven(seed: int, settings: EkfSettings, steps: int) -> tuple[EkfSlam, float, float]:
    """One drive → the filter, its worst error while a loop was open, and at the end [m]."""
    rng, slam, true, worst = np.random.default_rng(seed), EkfSlam(settings), Pose(), 0.0
    trees = park(rng)
    for _ in range(steps):
        x, y, turn = rng.multivariate_normal(np.zeros(3), STEP.covariance)
        moved = Pose(STEP.pose.x + x, STEP.pose.y + y, STEP.pose.heading + turn)
        home = Pose(0.0, RADIUS).bearing_to(true.x, true.y) + math.pi / 2
        moved = moved @ Pose(0.0, 0.0, 0.1 * math.remainder(home - true.heading, 2 * math.pi))
        out = Pose(0.0, RADIUS).distance_to(true.x, true.y) - RADIUS
        moved = moved @ Pose(0.0, 0.0, 0.01 * out)
        told = Pose(moved.x - x, moved.y - y, moved.heading - turn)
        true = true @ moved
        slam.advance(Increment(told, STEP.covariance))
        seen = true.inverse().apply(trees)
        near = np.flatnonzero((np.hypot(*seen.T) < SIGHT) & (seen[:, 0] > 0))
        if len(near):
            place = seen[rng.choice(near)]
            reach, bearing = rng.multivariate_normal((np.hypot(*place), np.arctan2(place[1], place[0])), NOISE)
            slam.see([Sighting(range=float(reach), bearing=float(bearing), covariance=NOISE)])
        worst = max(worst, slam.estimate.pose.distance_to(true.x, true.y))
    return slam, worst, slam.estimate.pose.distance_to(true.x, true.y)


@pytest.mark.parametrize("seed", [2, 3, 5])
def test_a_loop_closes_by_the_trees_that_are_found_again_together(seed: int) -> None:
    slam, _, left = driven(seed, EkfSettings(), round(1.6 * LAP))
    assert abs(len(slam.landmarks) - TREES) <= 1
    assert left < 5.0


def test_were_every_sighting_decided_on_at_once_the_robot_would_be_lost() -> None:
    slam, worst, _ = driven(2, EkfSettings(vague=100.0, found_again=TREES), round(1.6 * LAP))
    assert len(slam.landmarks) > 1.3 * TREES
    assert worst > 20.0


def test_a_vague_sighting_of_what_was_left_behind_is_new_and_a_clear_one_is_not() -> None:
    for spread, fates in ((0.01, ["matched"]), (3.0, ["new"])):
        slam = EkfSlam(EkfSettings(still_every=1))
        for _ in range(4):
            slam.see([Sighting(range=10.0, bearing=0.0, covariance=NOISE)])
        for _ in range(60):
            slam.advance(Increment(Pose(1.0, 0.0, 0.0), np.zeros((3, 3))))
        slam.advance(Increment(Pose(-58.0, 0.0, 0.0), spread**2 * np.diag([1.0, 1.0, 0.0])))
        slam.see([Sighting(range=8.0, bearing=0.0, covariance=NOISE)])
        assert [association.fate for association in slam.associations] == fates


def test_who_is_known_by_name_is_not_found_again_by_others() -> None:
    slam = EkfSlam(EkfSettings(still_every=1))
    for number in (1, 2):
        slam.see([Sighting(range=10.0, bearing=0.0, covariance=NOISE, id=number)])
    assert not slam.table.new[:2].any()


def test_joining_at_the_end_of_a_loop_turns_everything_as_far_as_it_must() -> None:
    """Half a radian: corrected in one go, the robot would end a metre off."""
    state, sure = InvariantFilter(), np.diag([1e-4, 1e-6])
    places = np.array([(20.0, 3.0), (24.0, -4.0), (30.0, 1.0)])
    for place in places:
        state.add(np.array([np.hypot(*place), np.arctan2(place[1], place[0])]), sure)
    state.predict(Increment(Pose(12.0, 0.0, 0.0), np.diag([4.0, 4.0, 0.25])))
    true = Pose(13.0, -1.5, 0.5)
    for seen in true.inverse().apply(places):
        state.add(np.array([np.hypot(*seen), np.arctan2(seen[1], seen[0])]), sure)
    state.join(np.arange(3), np.arange(3, 6))
    assert len(state.places) == 3
    assert state.pose.vector == pytest.approx(true.vector, abs=0.3)
    assert state.places == pytest.approx(places, abs=0.3)
