"""Bearings from several poses crossed."""

import math

import numpy as np
import pytest

from core.geometry import Ray
from core.perception.sound.triangulation import _gaps, _slopes, cross


def seen(x: float, y: float, target: tuple[float, float], error: float = 0.0, sd: float = 0.05) -> Ray:
    return Ray(x=x, y=y, azimuth=math.atan2(target[1] - y, target[0] - x) + error, sd=sd)


def test_exact_bearings_cross_in_the_place():
    place = cross([seen(0, 0, (3, 2)), seen(1, -1, (3, 2)), seen(2, 0, (3, 2))])
    assert place.position == pytest.approx([3, 2], abs=1e-4) and place.used == (0, 1, 2)


def test_bearings_that_are_wrong_are_left_out():
    target = (3.0, 2.0)
    bearings = [seen(0.3 * n, -0.3 * n, target, 0.01 * (-1) ** n) for n in range(6)]
    bearings[2:2] = [seen(0.5, 0.5, (-3, 1)), seen(0.2, 0.1, (0, -4))]
    place = cross(bearings)
    assert place.position == pytest.approx(target, abs=0.3) and place.used == (0, 1, 4, 5, 6, 7)


def test_the_covariance_holds():
    rng = np.random.default_rng(0)
    distances = []
    for _ in range(200):
        target = rng.uniform([1.5, -1.5], [3, 1.5])
        poses = [(0, 0), (0.5, 0.6), (0.2, -0.7), (0.8, 0.9), (0.6, -0.8), (0, 1.0)]
        place = cross([seen(x, y, tuple(target), rng.normal(scale=0.04), 0.04) for x, y in poses])
        if place.position is not None:
            gap = place.position - target
            distances.append(gap @ np.linalg.solve(place.covariance, gap))
    assert len(distances) > 180
    assert 0.85 < np.mean(np.array(distances) < 5.99) <= 1.0


@pytest.mark.parametrize(
    ("bearings", "words"),
    [
        ([], "one place only"),
        ([seen(0, 0, (3, 2))], "one place only"),
        ([seen(0, 0, (3, 0)), seen(0.5, 0, (3, 0)), seen(1, 0, (3, 0))], "nearly parallel"),
        ([seen(0, 0, (-3, 1)), seen(0.0, 1.0, (3, 3))], "nearly parallel"),
        ([seen(0, 0, (9, 0), sd=0.3), seen(0, 1.4, (9, 0), sd=0.3)], "too uncertain"),
        ([Ray(x=math.nan, y=0, azimuth=0, sd=0.1), Ray(x=0, y=0, azimuth=0, sd=2.0)], "one place only"),
    ],
)
def test_where_nothing_can_be_known_nothing_is_guessed(bearings, words):
    place = cross(bearings)
    assert place.position is None and words in place.reason


def test_the_slope_of_a_bearing_is_its_finite_difference():
    table = np.array([[0.0, 0.0, 0.3, 0.1], [1.0, -2.0, 1.0, 0.1]])
    at, step = np.array([2.0, 1.0]), 1e-6
    for axis in range(2):
        aside = np.eye(2)[axis] * step
        change = (_gaps(table, at + aside) - _gaps(table, at - aside)) / (2 * step)
        assert _slopes(table, at)[:, axis] == pytest.approx(change, abs=1e-6)
