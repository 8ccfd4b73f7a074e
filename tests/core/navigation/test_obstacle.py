"""What stands in the way."""

import math

import numpy as np
import pytest

from core.navigation.obstacle import free_space, obstacle_ahead, why_no_headway

NOTHING = np.zeros((0, 2))


def test_free_space_is_measured_from_the_body() -> None:
    assert free_space(np.array([[0.0, -0.5], [2.0, 0.0]]), 0.09) == pytest.approx(0.41)
    assert free_space(np.array([[0.05, 0.0]]), 0.09) == 0.0
    assert math.isinf(free_space(NOTHING, 0.09))


def test_only_what_lies_on_the_track_is_ahead() -> None:
    assert obstacle_ahead(np.array([[0.39, 0.0], [0.1, 0.3], [-0.2, 0.0]]), 0.09) == pytest.approx(0.30)
    assert obstacle_ahead(np.array([[0.3, 0.2], [-0.2, 0.0], [3.0, 0.0]]), 0.09) is None
    assert obstacle_ahead(NOTHING, 0.09) is None


def test_the_sentence_tells_how_far_away_it_is() -> None:
    assert why_no_headway(np.array([[0.29, 0.01]]), 0.09) == "Something blocks the way 0.20 m ahead."
    assert "no further" in why_no_headway(NOTHING, 0.09)
