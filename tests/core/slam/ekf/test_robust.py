import numpy as np
import pytest

from core.slam.ekf.filter import Filter
from core.slam.ekf.measurement_model import expected
from core.slam.ekf.robust import SlipThresholds, displaced, mahalanobis, trust, with_noise
from tests.core.slam.filter_states import FORMS, NOISE, some_filter

SLIP = SlipThresholds()


def spread(size: int, seed: int = 0) -> np.ndarray:
    root = np.random.default_rng(seed).normal(size=(size, size + 3))
    return root @ root.T


def test_a_sighting_is_as_odd_as_it_is_far_from_what_the_others_tell_of_it() -> None:
    total, off = spread(8), np.random.default_rng(1).normal(size=(4, 2))
    odd = mahalanobis(total, off)
    for one in range(4):
        own, others = np.arange(2) + 2 * one, np.delete(np.arange(8), [2 * one, 2 * one + 1])
        told = total[np.ix_(own, others)] @ np.linalg.inv(total[np.ix_(others, others)])
        left = off.ravel()[own] - told @ off.ravel()[others]
        conditional = total[np.ix_(own, own)] - told @ total[np.ix_(others, own)]
        assert odd[one] == pytest.approx(left @ np.linalg.solve(conditional, left))


def test_a_single_sighting_is_as_odd_as_it_is_surprising() -> None:
    total, off = spread(2), np.array([[0.3, -0.2]])
    assert mahalanobis(total, off)[0] == pytest.approx(off[0] @ np.linalg.solve(total, off[0]))


def test_the_soft_gate_leaves_likely_sightings_alone_and_still_hears_the_others() -> None:
    noises = np.repeat(1e-4 * np.eye(2)[None], 3, 0)
    total = with_noise(1e-4 * np.eye(6), noises)
    off = np.array([[0.01, 0.0], [0.1, 0.0], [1.0, 0.0]])
    weights = trust(total, noises, off, mahalanobis(total, off), 4.0)
    assert weights[0] == 1.0
    assert 1.0 < weights[1] < weights[2] < np.inf


def test_sightings_that_err_alike_because_the_prediction_does_keep_their_say() -> None:
    noises = np.repeat(1e-4 * np.eye(2)[None], 5, 0)
    common = np.tile(np.eye(2), (5, 1))
    total = with_noise(0.04 * common @ common.T, noises)  # the robot is sure to 0.2 m, the sightings to 0.01 m
    off = np.tile([0.5, -0.4], (5, 1)) + 0.005 * np.random.default_rng(0).normal(size=(5, 2))
    assert (trust(total, noises, off, mahalanobis(total, off), 4.0) == 1.0).all()
    off[2] += 0.3
    weights = trust(total, noises, off, mahalanobis(total, off), 4.0)
    assert weights[2] > 10 * np.delete(weights, 2).max()


@pytest.mark.parametrize("form", FORMS)
def test_doubt_in_the_robot_s_place_adds_to_sightings_what_was_foretold(form: type[Filter]) -> None:
    state, indices = some_filter(form), np.arange(4)
    seen = expected(state.pose, state.places)[0]
    before = state.innovate(indices, seen).state
    foretold = state.perturbed(indices, SLIP.unnoticed)
    state.doubt(SLIP.unnoticed)
    assert np.allclose(state.innovate(indices, seen).state, before + foretold)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize(("wrong", "slipped"), [(0, False), (1, False), (4, True)])
def test_a_robot_that_was_moved_is_told_from_one_wrong_landmark(
    form: type[Filter], wrong: int, slipped: bool
) -> None:
    state, indices = some_filter(form, size=1e-3), np.arange(4)
    if wrong == 4:  # all, and alike: the robot was pushed by 0.7 m and turned
        elsewhere = type(state.pose)(state.pose.x + 0.6, state.pose.y - 0.4, state.pose.heading + 0.2)
        seen = expected(elsewhere, state.places)[0]
    else:
        seen = expected(state.pose, state.places)[0]
        seen[:wrong, 0] += 1.0
    innovation = state.innovate(indices, seen)
    total = with_noise(innovation.state, np.repeat(NOISE[None], 4, 0))
    odd = mahalanobis(total, innovation.residuals)
    assert displaced(total, innovation.residuals, odd, state.perturbed(indices, SLIP.unnoticed), SLIP) is slipped
