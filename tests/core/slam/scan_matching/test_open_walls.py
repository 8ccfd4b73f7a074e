"""A corridor without corners, seen by a laser of short range: nothing says how far along it the robot is."""

import math

import numpy as np
import pytest

from core.geometry import Pose
from core.message import Array
from core.slam.map.keyframe import thinned
from core.slam.motion import Increment
from core.slam.scan_matching.field_matching import ScanMatchingSettings
from core.slam.scan_matching.match_covariance import match_spread
from core.slam.scan_matching.scan_tracker import ScanTracker

REACH, WIDTH = 1.5, 1.0  # [m] of the laser; from the middle to either wall
UNKNOWN, FLOOR = np.array([0.75, 0.75, 0.5]), np.array([0.02, 0.02, 0.007])
WHEELS = Increment(Pose(0.03, 0.0, 0.0), np.diag([1e-4, 1e-8, 1e-6]))


def seen(seed: int, reach: float = REACH) -> Array:
    """Points (M, 2) [m] of the corridor's walls from its middle, with the laser's noise."""
    angles = np.arange(-2.09, 2.09, 2 * np.pi / 1024)
    ranges = WIDTH / np.maximum(np.abs(np.sin(angles)), 1e-3)
    angles, ranges = angles[ranges < reach], ranges[ranges < reach]
    ranges = ranges + np.random.default_rng(seed).normal(0.0, np.maximum(0.01, 0.01 * ranges))
    return np.column_stack((ranges * np.cos(angles), ranges * np.sin(angles)))


@pytest.mark.parametrize("reach", [1.5, 5.6])
def test_noise_on_straight_walls_is_little_information_along_them(reach: float) -> None:
    sds = []
    for seed in range(8):
        spread = match_spread(thinned(seen(seed, reach)), point_sd=0.1, wall=0.5, unknown=UNKNOWN, floor=FLOOR)
        sds.append(np.sqrt(spread.diagonal()))
    along, across, _ = np.mean(sds, axis=0)
    assert along > 0.12
    assert across < 0.03


def test_a_wall_across_is_information() -> None:
    end = np.column_stack((np.full(60, 1.0), np.linspace(-0.9, 0.9, 60)))
    spread = match_spread(np.vstack((seen(0), end)), point_sd=0.1, wall=0.5, unknown=UNKNOWN, floor=FLOOR)
    assert math.sqrt(spread[0, 0]) < 0.03


def test_along_a_corridor_the_move_and_its_doubt_are_those_of_the_wheels() -> None:
    tracker, place = ScanTracker(ScanMatchingSettings()), Pose(0.2, 0.0, 0.0)
    tracker.around([Pose(x, 0.0, 0.0).apply(seen(k)) for k, x in enumerate((-0.2, 0.0, 0.2))])
    for step in range(8):
        move = tracker.track(place, WHEELS, seen(10 + step))
        assert move.pose.x == pytest.approx(WHEELS.pose.x, abs=0.003)
        assert move.covariance[0, 0] == pytest.approx(WHEELS.covariance[0, 0], rel=0.2)
        place = place @ WHEELS.pose
    assert tracker.seen is not None
