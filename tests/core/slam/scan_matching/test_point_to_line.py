"""Laying scans on each other: derivatives by differences, known moves found again, and honest doubt."""

import math

import numpy as np
import pytest

from core.geometry import Pose
from core.perception.landmarks.deskew import beam_ends
from core.simulation.laser import SimulatedLaser
from core.simulation.world import world_named
from core.slam.map.keyframe import Keyframe
from core.slam.scan_matching.field_matching import (
    ScanMatchingSettings,
    ambiguity,
    match_scan,
    same_place,
    search_wide,
    spread,
)
from core.slam.scan_matching.likelihood_field import LikelihoodField, Match
from core.slam.scan_matching.point_to_line import LAST_REACH_M, WallPoints, align, residuals
from tests.core.slam.ring import LASER

HERE, THERE = Pose(0.2, -0.1, 0.4), Pose(0.7, 0.3, 0.9)


def view(pose: Pose, rng: np.random.Generator, world: str = "floor") -> Keyframe:
    """What the laser sees from there."""
    scan = SimulatedLaser(LASER, rng).scan(
        world_named(world), 0.0, np.array([0.0, 1.0]), np.tile(pose.vector, (2, 1))
    )
    ends, hits = beam_ends(scan, LASER, None, 0.0)
    return Keyframe(id=0, submap=0, stamp=0.0, local=pose, ends=ends, hits=hits, eye=np.zeros(2))


def corridor() -> np.ndarray:
    """Two bare walls (N, 2) [m], 2 m apart."""
    x = np.arange(-5.0, 5.0, 0.05)
    return np.vstack([np.column_stack((x, np.full(len(x), side))) for side in (-1.0, 1.0)])


def test_the_slopes_of_an_alignment_are_those_of_differences() -> None:
    rng = np.random.default_rng(1)
    base, other = WallPoints(view(HERE, rng)), WallPoints(view(THERE, rng))
    pose = HERE.inverse() @ THERE
    found = residuals(base, other, pose, LAST_REACH_M)
    assert found is not None
    for axis in range(3):
        step = np.eye(3)[axis] * 1e-7
        ahead = residuals(base, other, Pose(*(pose.vector + step).tolist()), LAST_REACH_M)
        behind = residuals(base, other, Pose(*(pose.vector - step).tolist()), LAST_REACH_M)
        assert ahead is not None
        assert behind is not None
        assert (ahead[0] - behind[0]) / 2e-7 == pytest.approx(found[1][:, axis], abs=1e-4)


def test_an_alignment_finds_a_known_move_and_does_not_claim_too_much() -> None:
    errors, squared = list[float](), list[float]()
    truth = HERE.inverse() @ THERE
    for seed in range(12):
        rng = np.random.default_rng(seed)
        guess = truth @ Pose(*(rng.normal(size=3) * (0.08, 0.08, 0.05)).tolist())
        found = align(WallPoints(view(HERE, rng)), WallPoints(view(THERE, rng)), guess)
        assert found is not None
        pose, covariance = found
        error = pose.vector - truth.vector
        errors.append(math.hypot(error[0], error[1]))
        squared.append(float(error @ np.linalg.solve(covariance, error)))
    assert max(errors) < 0.03
    assert np.mean(squared) < 6.0


def test_views_of_different_rooms_are_not_aligned() -> None:
    rng = np.random.default_rng(2)
    assert align(WallPoints(view(HERE, rng)), WallPoints(view(Pose(-5.0, 6.0, 0.0), rng, "floor")), Pose()) is None


def test_a_wide_search_finds_a_place_two_metres_off() -> None:
    rng = np.random.default_rng(3)
    field = LikelihoodField(np.vstack([HERE.apply(view(HERE, rng).points), THERE.apply(view(THERE, rng).points)]))
    points, truth = view(Pose(0.5, 0.0, 0.6), rng).points, Pose(0.5, 0.0, 0.6)
    *_, found = search_wide(field, points, Pose(-1.2, 1.1, 0.9), 2.5, math.radians(24))
    assert same_place(found[0].pose, truth)
    assert found[0].pose.distance_to(truth.x, truth.y) < 0.04
    assert all(not same_place(found[0].pose, other.pose) for other in found[1:])
    near = match_scan(field, points, Pose(0.45, 0.06, 0.62), 0.2, math.radians(4))
    assert near.pose.distance_to(truth.x, truth.y) < 0.04


def test_along_a_bare_corridor_a_match_can_slide_and_across_it_cannot() -> None:
    walls = corridor()
    seen = walls[np.abs(walls[:, 0]) < 3.0]
    spread = ambiguity(LikelihoodField(walls), seen, Match(Pose(), 1.0))
    assert math.sqrt(spread[0, 0]) > 0.4
    assert math.sqrt(spread[1, 1]) < 0.06
    rng = np.random.default_rng(4)
    room = view(HERE, rng)
    told = ambiguity(LikelihoodField(room.points), room.points, Match(Pose(), 1.0))
    assert math.sqrt(float(np.linalg.eigvalsh(told)[-1])) < 0.1


def test_in_a_bare_corridor_a_match_and_its_covariance_say_nothing_of_the_way_along() -> None:
    """0.03 and 0.13 m where the noise of near points passes for walls across, and a search's reach for doubt."""
    rng = np.random.default_rng(4)
    bearings = np.linspace(-2.0, 2.0, 240)
    sides = np.column_stack((np.cos(bearings), np.sin(bearings))) / np.abs(np.sin(bearings))[:, None]
    seen = sides[np.abs(sides[:, 0]) < 4.0]
    seen = seen * (1 + rng.normal(scale=0.01, size=(len(seen), 1)))
    field = LikelihoodField(corridor())
    own = spread(field, seen, Pose(), ScanMatchingSettings())
    around = ambiguity(field, seen, Match(Pose(), 1.0), 0.1)
    assert math.sqrt(own[0, 0]) > 0.09
    assert math.sqrt(own[1, 1]) < 0.03
    assert math.sqrt(around[0, 0]) > 0.25


def test_a_view_tells_what_lies_on_its_walls_from_what_it_looked_through() -> None:
    shown = view(HERE, np.random.default_rng(5))
    points = np.asarray(shown.ends)[shown.hits]
    on, through = shown.judge(points)
    assert on.mean() > 0.99
    assert not through.any()
    far = points[np.hypot(points[:, 0], points[:, 1]) > 1.5]
    on, through = shown.judge(0.5 * far)
    assert through.mean() > 0.8
    on, through = shown.judge(1.6 * points)
    assert through.mean() < 0.15
