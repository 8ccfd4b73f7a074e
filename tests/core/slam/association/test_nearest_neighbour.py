import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.slam.association.nearest_neighbour import Assignment, associate


def assign(
    distances: list[list[float]], sizes: np.ndarray | None = None, alike: np.ndarray | None = None
) -> Assignment:
    table = np.array(distances, dtype=float)
    return associate(
        table,
        np.zeros_like(table) if sizes is None else sizes,
        np.ones_like(table, dtype=bool) if alike is None else alike,
        gate=9.21,
        fresh=25.0,
        margin=2.0,
    )


def test_the_nearest_is_matched_and_the_far_one_is_fresh() -> None:
    found = assign([[0.5, 40.0], [60.0, 30.0]])
    assert found.matches == ((0, 0),)
    assert found.fresh == (1,)


def test_between_gate_and_fresh_a_sighting_is_ignored() -> None:
    assert assign([[15.0, 40.0]]) == Assignment()


def test_two_sightings_never_share_a_landmark() -> None:
    found = assign([[0.5, 8.0], [4.0, 200.0]])
    landmarks = [landmark for _, landmark in found.matches]
    assert len(set(landmarks)) == len(landmarks)


def test_the_whole_is_weighed_and_not_each_alone() -> None:
    """Alone both would take landmark 0; together the second one has no other."""
    found = assign([[1.0, 1.5], [1.0, 90.0]])
    assert found.matches == ((0, 1), (1, 0))


def test_a_doubtful_sighting_is_left_out() -> None:
    assert assign([[1.0, 2.0]]).matches == ()
    assert assign([[1.0, 6.0]]).matches == ((0, 0),)


def test_two_sightings_that_fit_one_landmark_alike_are_both_left_out() -> None:
    found = assign([[1.0], [1.5]])
    assert found == Assignment()
    assert assign([[1.0], [6.0]]).matches == ((0, 0),)


def test_an_uncertain_landmark_does_not_attract_everything() -> None:
    sizes = np.array([[0.0, 8.0]])
    assert assign([[4.0, 0.5]], sizes).matches == ((0, 0),)


def test_another_kind_is_never_a_match_yet_may_stand_nearby() -> None:
    other = np.array([[False]])
    assert assign([[1.0]], alike=other) == Assignment()
    assert assign([[12.0]], alike=other).fresh == (0,)
    assert assign([[12.0]]).fresh == ()


@given(st.integers(1, 6), st.integers(1, 6), st.integers(0, 10_000))
@settings(max_examples=100)
def test_every_match_is_unique_and_inside_the_gate(sightings: int, landmarks: int, seed: int) -> None:
    table = np.random.default_rng(seed).exponential(12.0, (sightings, landmarks))
    found = assign(table.tolist())
    rows, columns = [row for row, _ in found.matches], [column for _, column in found.matches]
    assert len(set(rows)) == len(rows)
    assert len(set(columns)) == len(columns)
    assert all(table[pair] < 9.21 for pair in found.matches)
    assert not set(rows) & set(found.fresh)
    assert all((table[row] > 25.0).all() for row in found.fresh)


@pytest.mark.parametrize("seed", range(20))
def test_without_doubt_the_cheapest_assignment_is_taken(seed: int) -> None:
    rng = np.random.default_rng(seed)
    order = rng.permutation(5)
    table = rng.uniform(20, 24, (5, 5))
    table[np.arange(5), order] = rng.uniform(0, 3, 5)
    assert dict(assign(table.tolist()).matches) == dict(enumerate(order.tolist()))
