"""Rays through floor plans."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.geometry import rotation
from core.simulation.world import LAB, Rect, Surfaces, cast, distances, outline

ROOM = Surfaces(faces=outline([Rect(-1.0, -2.0, 3.0, 4.0)]), posts=np.empty((0, 3)))
AROUND = np.linspace(-np.pi, np.pi, 360, endpoint=False)
RAYS = np.column_stack((np.cos(AROUND), np.sin(AROUND)))


@pytest.mark.parametrize(
    ("heading", "distance"), [(0.0, 3.0), (np.pi / 2, 4.0), (np.pi, 1.0), (-np.pi / 2, 2.0), (np.pi / 4, 3 * 2**0.5)]
)
def test_a_ray_ends_at_the_wall_it_points_to(heading: float, distance: float) -> None:
    ray = np.array([[np.cos(heading), np.sin(heading)]])
    hit = cast(np.zeros(2), ray, ROOM)
    assert hit.distance[0] == pytest.approx(distance)
    assert hit.cosine[0] == pytest.approx(max(abs(np.cos(heading)), abs(np.sin(heading))))


def test_a_longer_direction_counts_in_its_own_lengths() -> None:
    assert cast(np.zeros(2), np.array([[2.0, 0.0]]), ROOM).distance[0] == pytest.approx(1.5)


@given(turn=st.floats(-3.1, 3.1), x=st.floats(-5, 5), y=st.floats(-5, 5))
def test_turning_and_moving_everything_changes_no_distance(turn: float, x: float, y: float) -> None:
    seen, matrix = LAB.surfaces(0.12), rotation(turn)
    moved = Surfaces(
        faces=np.hstack((seen.faces[:, :2] @ matrix.T + (x, y), seen.faces[:, 2:] @ matrix.T + (x, y))),
        posts=np.column_stack((seen.posts[:, :2] @ matrix.T + (x, y), seen.posts[:, 2])),
    )
    here = np.array([0.4, 0.3])
    rays = RAYS @ rotation(0.001).T  # no ray runs exactly into a corner
    before = cast(here, rays, seen)
    after = cast(here @ matrix.T + (x, y), rays @ matrix.T, moved)
    np.testing.assert_allclose(after.distance, before.distance, atol=1e-6)
    np.testing.assert_allclose(after.cosine, before.cosine, atol=1e-6)


def test_a_post_is_met_on_its_near_side() -> None:
    post = Surfaces(faces=ROOM.faces, posts=np.array([[2.0, 0.0, 0.25]]))
    hit = cast(np.zeros(2), np.array([[1.0, 0.0], [1.0, 0.1259], [1.0, 0.13]]), post)
    assert hit.distance[0] == pytest.approx(1.75)
    assert hit.cosine[0] == pytest.approx(1.0)
    assert hit.along[0] == pytest.approx(np.pi * 0.25)  # its side that looks to -x
    assert hit.surface.tolist() == [4, 4, hit.surface[2]]
    assert hit.surface[2] < 4


def test_a_ray_that_meets_nothing_says_so() -> None:
    gap = Surfaces(faces=np.array([[1.0, 1.0, 1.0, -1.0]]), posts=np.empty((0, 3)))
    hit = cast(np.zeros(2), np.array([[-1.0, 0.0], [1.0, 0.0]]), gap)
    assert hit.surface.tolist() == [-1, -1]  # the second runs against the closed side
    assert np.isinf(hit.distance).all()
    assert np.isnan(hit.along).all()


def test_a_reach_only_leaves_out_what_is_beyond_it() -> None:
    everything = cast(np.zeros(2), RAYS, LAB.surfaces(0.12)).distance
    near = cast(np.zeros(2), RAYS, LAB.surfaces(0.12), 2.5).distance
    within = everything <= 2.5
    np.testing.assert_array_equal(near[within], everything[within])
    assert (near[~within] > 2.5).all()


def test_origins_that_move_are_cast_one_by_one() -> None:
    origins = np.column_stack((np.linspace(0, 0.05, 360), np.linspace(0, -0.03, 360)))
    together = cast(origins, RAYS, LAB.surfaces(0.12)).distance
    alone = [cast(o, r[None], LAB.surfaces(0.12)).distance[0] for o, r in zip(origins[::30], RAYS[::30], strict=True)]
    np.testing.assert_allclose(together[::30], alone, atol=1e-9)


def test_the_nearest_distance_is_the_shortest_ray() -> None:
    fine = np.linspace(-np.pi, np.pi, 3600)
    for here in (np.array([0.0, 0.0]), np.array([2.9, 1.4]), np.array([-1.2, -1.9])):
        rays = np.column_stack((np.cos(fine), np.sin(fine)))
        shortest = cast(here, rays, LAB.obstacles).distance.min()
        assert distances(here, LAB.obstacles).min() == pytest.approx(shortest, abs=2e-4)
