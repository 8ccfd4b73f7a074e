"""Every Jacobian of both forms against finite differences, through the errors as the covariance counts them."""

import copy

import numpy as np
import pytest

from core.geometry import Pose, rotation
from core.slam.ekf.filter import Filter
from core.slam.ekf.invariant import InvariantFilter, shift_matrix
from core.slam.ekf.measurement_model import expected, residual
from core.slam.motion import Increment
from tests.core.slam.filter_states import (
    FORMS,
    NOISE,
    apart_by,
    correct,
    error_between,
    moved,
    predicted,
    slope,
    some_filter,
)

MOVE = Pose(0.3, -0.1, 0.4)
SPREAD = np.array([[4e-3, 1e-3, -5e-4], [1e-3, 3e-3, 4e-4], [-5e-4, 4e-4, 2e-3]])


@pytest.mark.parametrize("form", FORMS)
def test_errors_are_what_a_correction_takes_away(form: type[Filter]) -> None:
    state = some_filter(form)
    error = 0.1 * np.random.default_rng(3).normal(size=11)
    assert np.allclose(error_between(state, apart_by(state, error)), error)


@pytest.mark.parametrize("form", FORMS)
def test_prediction_spreads_the_covariance_by_its_jacobians(form: type[Filter]) -> None:
    state = some_filter(form)
    after = moved(state, MOVE)
    carry = slope(lambda error: error_between(after, moved(apart_by(state, error), MOVE)), 11)
    noise = slope(lambda off: error_between(after, moved(state, MOVE, off)), 3)
    told = predicted(state, Increment(MOVE, SPREAD))
    wanted = carry @ state.covariance.dense() @ carry.T + noise @ SPREAD @ noise.T
    assert np.allclose(told.covariance.dense(), wanted, atol=1e-6)
    assert told.pose == after.pose


def test_without_noise_the_invariant_error_does_not_change_however_large_it_is() -> None:
    state = some_filter(InvariantFilter)
    error = np.random.default_rng(3).normal(size=11)
    after = error_between(moved(state, MOVE), moved(apart_by(state, error), MOVE))
    assert np.allclose(after, error)


@pytest.mark.parametrize("form", FORMS)
def test_expectations_spread_by_the_sighting_s_jacobian(form: type[Filter]) -> None:
    state = some_filter(form)

    def sighted(error: np.ndarray) -> np.ndarray:
        truth = apart_by(state, error)
        return residual(expected(truth.pose, truth.places)[0], expected(state.pose, state.places)[0]).ravel()

    jacobian = slope(sighted, 11)
    _, states = copy.deepcopy(state).expect()
    full = jacobian @ state.covariance.dense() @ jacobian.T
    for index in range(4):
        part = slice(2 * index, 2 * index + 2)
        assert np.allclose(states[index], full[part, part], atol=1e-6)


def test_the_invariant_sighting_s_jacobian_knows_nothing_of_the_heading() -> None:
    state = some_filter(InvariantFilter)

    def sighted(turn: np.ndarray) -> np.ndarray:
        error = np.zeros(11)
        error[2] = turn[0]
        truth = apart_by(state, error)
        return residual(expected(truth.pose, truth.places)[0], expected(state.pose, state.places)[0]).ravel()

    assert np.allclose(slope(sighted, 1), 0.0, atol=1e-9)


@pytest.mark.parametrize("form", FORMS)
def test_a_stacked_update_is_the_textbook_s_with_jacobians_by_differences(form: type[Filter]) -> None:
    state = some_filter(form)
    indices = np.array([3, 0, 2])

    def sighted(error: np.ndarray) -> np.ndarray:
        truth = apart_by(state, error)
        seen = expected(truth.pose, truth.places[indices])[0]
        return residual(seen, expected(state.pose, state.places[indices])[0]).ravel()

    jacobian, before = slope(sighted, 11), state.covariance.dense()
    noises = np.array([np.diag([0.01, 0.002]), np.diag([0.02, 0.001]), np.array([[0.01, 0.001], [0.001, 0.003]])])
    noise = np.zeros((6, 6))
    for k in range(3):
        noise[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] = noises[k]
    readings = expected(state.pose, state.places[indices])[0] + 0.02
    gain = before @ jacobian.T @ np.linalg.inv(jacobian @ before @ jacobian.T + noise)
    corrected = apart_by(state, gain @ np.full(6, 0.02))
    correct(state, indices, readings, noises)
    assert np.allclose(state.covariance.dense(), (np.eye(11) - gain @ jacobian) @ before, atol=1e-6)
    assert np.allclose(state.pose.vector, corrected.pose.vector, atol=1e-6)
    assert np.allclose(state.places, corrected.places, atol=1e-6)


@pytest.mark.parametrize("form", FORMS)
def test_a_new_landmark_s_covariance_follows_its_jacobians(form: type[Filter]) -> None:
    state, reading = some_filter(form), np.array([1.7, 0.6])
    noise = np.array([[4e-3, 5e-4], [5e-4, 2e-3]])

    def grown(truth: Filter, off: np.ndarray) -> Filter:
        other = copy.deepcopy(truth)
        other.add(reading + off, NOISE)
        return other

    estimate = grown(state, np.zeros(2))
    carry = slope(lambda error: error_between(estimate, grown(apart_by(state, error), np.zeros(2))), 11)
    onto = slope(lambda off: error_between(estimate, grown(state, off)), 2)
    wanted = carry @ state.covariance.dense() @ carry.T + onto @ noise @ onto.T
    state.add(reading, noise)
    assert np.allclose(state.covariance.dense(), wanted, atol=1e-6)


@pytest.mark.parametrize("form", FORMS)
def test_the_difference_of_two_landmarks_spreads_by_its_jacobian(form: type[Filter]) -> None:
    state = some_filter(form)
    jacobian = slope(lambda error: np.subtract(*apart_by(state, error).places[[1, 3]]), 11)
    difference, spread = state.apart(1, 3)
    assert np.allclose(difference, state.places[1] - state.places[3])
    assert np.allclose(spread, jacobian @ state.covariance.dense() @ jacobian.T, atol=1e-6)


@pytest.mark.parametrize("form", FORMS)
def test_what_is_shown_is_the_covariance_in_the_world_s_axes(form: type[Filter]) -> None:
    state = some_filter(form)

    def world(error: np.ndarray) -> np.ndarray:
        truth = apart_by(state, error)
        return np.concatenate((truth.pose.vector - state.pose.vector, (truth.places - state.places).ravel()))

    jacobian = slope(world, 11)
    shown = jacobian @ state.covariance.dense() @ jacobian.T
    assert np.allclose(state.pose_covariance(), shown[:3, :3], atol=1e-6)
    for index, spread in enumerate(state.place_covariances()):
        part = slice(3 + 2 * index, 5 + 2 * index)
        assert np.allclose(spread, shown[part, part], atol=1e-6)


@pytest.mark.parametrize("form", FORMS)
def test_what_is_shown_does_not_wait_for_the_covariance_to_settle(form: type[Filter]) -> None:
    state = some_filter(form)
    for _ in range(3):
        state.predict(Increment(MOVE, SPREAD))
    waiting = state.pose_covariance()
    state.settle()
    assert np.allclose(waiting, state.pose_covariance())


@pytest.mark.parametrize("angle", [0.0, 1e-12, 0.3, -2.0])
def test_the_shift_matrix_is_the_mean_of_the_turns_on_the_way(angle: float) -> None:
    way = [rotation(angle * share) for share in (np.arange(20000) + 0.5) / 20000]
    assert np.allclose(shift_matrix(angle), np.mean(way, axis=0), atol=1e-8)
