"""An edge that only the camera sees, on a wall that the laser sees: how far it is, and how surely."""

import math

import numpy as np
import pytest

from core.geometry import Pose
from core.perception.landmarks.edges import EdgeSettings, ImageEdge
from core.perception.landmarks.landmarks import edges_on_walls

EYE = Pose(0.04, 0.0, 0.0)
WALL = np.column_stack((np.linspace(0.5, 5.0, 150), np.full(150, 1.0)))  # on the left, 1 m aside


def edge_at(x: float, y: float, step: float = 50.0, matched: bool = False) -> ImageEdge:
    bearing = math.atan2(y - EYE.y, x - EYE.x)
    return ImageEdge(top=np.zeros(2), bottom=np.zeros(2), bearing=bearing, matched=matched, step=step)


@pytest.mark.parametrize("x", [2.2, 3.0, 4.0])
def test_an_edge_on_a_wall_is_as_far_as_the_wall(x: float) -> None:
    (seen,), others = edges_on_walls((edge_at(x, 1.0),), WALL, EYE, 0.0, EdgeSettings())
    assert not others and seen.kind == "rise"
    assert np.allclose(seen.position, (x, 1.0), atol=1e-6)


def test_what_its_distance_owes_to_the_bearing_grows_where_the_wall_is_seen_flat() -> None:
    settings = EdgeSettings()
    near, far = (edges_on_walls((edge_at(x, 1.0),), WALL, EYE, 0.0, settings)[0][0] for x in (2.2, 4.5))
    assert far.covariance[0, 0] > 4 * near.covariance[0, 0]
    rng = np.random.default_rng(0)
    found = []
    for _ in range(400):
        off = edge_at(3.0, 1.0)
        turned = ImageEdge(
            top=off.top, bottom=off.bottom, step=50.0, bearing=off.bearing + rng.normal(0, settings.bearing_sd)
        )
        moved = WALL + np.array([0.0, rng.normal(0, settings.wall_sd)])
        found.append(edges_on_walls((turned,), moved, EYE, 0.0, settings)[0][0].range)
    claimed = edges_on_walls((edge_at(3.0, 1.0),), WALL, EYE, 0.0, settings)[0][0]
    assert 0.8 < np.var(found) / claimed.covariance[0, 0] < 1.2


def test_an_edge_without_a_wall_behind_it_is_a_bearing_only() -> None:
    post = np.vstack((WALL[:40], WALL[60:] + np.array([0.0, 0.6])))  # the wall jumps back
    sightings, others = edges_on_walls((edge_at(1.75, 1.0), edge_at(1.0, -2.0)), post, EYE, 0.0, EdgeSettings())
    assert not sightings and len(others) == 2


def test_an_edge_that_confirms_a_corner_is_no_second_landmark() -> None:
    assert edges_on_walls((edge_at(3.0, 1.0, matched=True),), WALL, EYE, 0.0, EdgeSettings()) == ((), ())


def test_the_side_on_which_it_is_brighter_is_its_kind() -> None:
    (seen,), _ = edges_on_walls((edge_at(3.0, 1.0, step=-40.0),), WALL, EYE, 0.0, EdgeSettings())
    assert seen.kind == "fall"
