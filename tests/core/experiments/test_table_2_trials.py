"""Where a wall counts as straight, and how far off its distance the robot is."""

import math
from typing import Any, cast

import numpy as np
import pytest

from core.experiments.spoken_room import SpokenRoom
from core.experiments.table_2_trials import LEADING_DISTANCE_M, aside, lead_on
from core.geometry import Pose

WALL = np.array([[0.0, 0.0, 3.0, 0.0]])  # along x, open to +y
NO_POSTS = np.empty((0, 3))


@pytest.mark.parametrize(
    ("x", "y", "heading", "told"),
    [
        (1.5, 0.5, 0.0, 0.0),
        (1.5, 0.56, 0.1, 0.06),
        (0.6, 0.45, 0.0, -0.05),
        (0.4, 0.5, 0.0, None),  # where it begins
        (2.6, 0.5, 0.0, None),  # where it ends
        (1.5, 0.9, 0.0, None),  # too far
        (1.5, 0.5, 1.0, None),  # on its way from it
        (1.5, 0.5, math.pi, None),  # on its left
        (1.5, -0.5, 0.0, None),  # behind it
    ],
)
def test_how_far_off_it_is_counts_beside_the_middle_of_a_wall_on_the_right(
    x: float, y: float, heading: float, told: float | None
) -> None:
    off = aside(Pose(x, y, heading), WALL, NO_POSTS)
    assert off == (None if told is None else pytest.approx(told))


def test_nothing_counts_where_another_wall_or_a_post_is_near() -> None:
    here = Pose(1.5, 0.5, 0.0)
    assert aside(here, np.vstack((WALL, [[2.2, 0.0, 2.2, 1.0]])), NO_POSTS) is None
    assert aside(here, WALL, np.array([[1.5, 1.2, 0.05]])) is None
    assert aside(here, WALL, np.array([[1.5, 1.6, 0.05]])) == pytest.approx(0.0)


class Floor:
    """A room in which every way is free."""

    def __init__(self, seed: int) -> None:
        self.chance = np.random.default_rng(seed)

    def put(self, name: str, **fields: Any) -> None:
        pass


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("ann", [(1.5, 1.0), (2.5, 1.1)])
def test_who_leads_never_walks_into_the_robot_and_never_stands_for_good(ann: tuple[float, float], seed: int) -> None:
    robot = Pose(1.35, 0.53, 1.3)
    goal = lead_on(cast(SpokenRoom, Floor(seed)), ann, robot)
    assert goal is not None
    nearest = min(robot.distance_to(*place) for place in np.linspace(ann, goal, 100))
    assert nearest > min(LEADING_DISTANCE_M, robot.distance_to(*ann)) - 0.02
