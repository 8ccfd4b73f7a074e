import numpy as np

from core.slam.association.joint_compatibility import Pairs
from core.slam.association.merge_duplicates import found_again

OLD = np.array([(0.0, 0.0), (7.0, 1.0), (3.0, 6.0), (11.0, 5.0), (-6.0, 4.0)])
PLACED = 0.1  # [m] sd with which every landmark lies among its own
COMMON = 3.0  # [m] sd of what all new ones share


def compared(new: np.ndarray, old: np.ndarray) -> tuple[Pairs, np.ndarray, np.ndarray]:
    """All pairs within reach, how far they lie apart, and the covariance of that."""
    off = new[:, None] - old
    near = np.argwhere(np.hypot(off[..., 0], off[..., 1]) < 4 * COMMON)
    rows, columns = near.T
    shared = PLACED**2 * ((rows[:, None] == rows).astype(float) + (columns[:, None] == columns)) + COMMON**2
    return tuple((int(a), int(b)) for a, b in near), off[rows, columns], np.kron(shared, np.eye(2))


def found(pairs: Pairs, apart: np.ndarray, spread: np.ndarray, nodes: int = 2000) -> Pairs:
    return found_again(pairs, apart, spread, gate=22.0, fewest=3, nodes=nodes)


def test_new_landmarks_that_lie_as_old_ones_do_are_these_though_each_alone_lies_nearer_to_another() -> None:
    shift = np.array([4.5, 0.5])
    new = OLD[:4] + shift + PLACED * np.random.default_rng(0).normal(size=(4, 2))
    alone = np.hypot(*(new[:, None] - OLD).transpose(2, 0, 1)).argmin(axis=1)
    assert (alone != np.arange(4)).any()
    assert found(*compared(new, OLD)) == ((0, 0), (1, 1), (2, 2), (3, 3))


def test_one_that_was_never_there_is_no_other() -> None:
    new = np.vstack((OLD[:4] + np.array([2.0, 1.0]), (7.5, -4.0)))
    assert found(*compared(new, OLD)) == ((0, 0), (1, 1), (2, 2), (3, 3))


def test_two_are_not_enough() -> None:
    assert found(*compared(OLD[:2] + 1.0, OLD)) == ()


def test_an_avenue_of_equal_distances_fits_in_many_ways_and_is_left_alone() -> None:
    avenue = np.column_stack((5.0 * np.arange(8), np.zeros(8)))
    assert found(*compared(avenue[2:6] + np.array([0.3, 0.2]), avenue)) == ()


def test_when_there_is_too_much_to_look_at_nothing_is_decided() -> None:
    pairs, apart, spread = compared(OLD + 1.0, OLD)
    assert found(pairs, apart, spread, nodes=3) == ()


def test_what_is_found_does_not_depend_on_the_order() -> None:
    pairs, apart, spread = compared(OLD[:4] + np.array([2.0, 1.0]), OLD)
    order = np.random.default_rng(1).permutation(len(pairs))
    rows = (2 * order[:, None] + np.arange(2)).ravel()
    mixed = found(tuple(pairs[k] for k in order), apart[order], spread[np.ix_(rows, rows)])
    assert sorted(mixed) == sorted(found(pairs, apart, spread))
