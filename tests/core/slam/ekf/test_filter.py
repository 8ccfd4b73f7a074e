import copy

import numpy as np
import pytest

from core.geometry import Pose
from core.slam.ekf.filter import Filter
from core.slam.ekf.measurement_model import expected
from core.slam.motion import Increment
from tests.core.slam.filter_states import FORMS, NOISE, correct, some_filter


@pytest.mark.parametrize("form", FORMS)
def test_sightings_as_expected_move_nothing_and_make_surer(form: type[Filter]) -> None:
    state = some_filter(form)
    before, spread = copy.deepcopy(state), state.covariance.dense()
    correct(state, np.arange(4), expected(state.pose, state.places)[0], np.repeat(NOISE[None], 4, 0))
    assert np.allclose(state.pose.vector, before.pose.vector)
    assert np.allclose(state.places, before.places)
    assert np.linalg.eigvalsh(spread - state.covariance.dense()).min() > -1e-12


@pytest.mark.parametrize("form", FORMS)
def test_moves_in_pieces_or_as_one_end_alike(form: type[Filter]) -> None:
    step = Increment(Pose(0.1, 0.01, 0.05), np.diag([1e-4, 5e-5, 2e-5]))
    pieces, whole = some_filter(form), some_filter(form)
    for _ in range(4):
        pieces.predict(step)
        pieces.settle()
    whole.predict(step.then(step).then(step).then(step))
    whole.settle()
    assert np.allclose(pieces.pose.vector, whole.pose.vector)
    assert np.allclose(pieces.covariance.dense(), whole.covariance.dense(), atol=1e-9)


@pytest.mark.parametrize("form", FORMS)
def test_standing_still_changes_nothing(form: type[Filter]) -> None:
    state = some_filter(form)
    before = state.covariance.dense()
    for _ in range(100):
        state.predict(Increment())
    state.settle()
    assert np.array_equal(state.covariance.dense(), before)


@pytest.mark.parametrize("form", FORMS)
def test_a_new_landmark_teaches_nothing_about_the_pose(form: type[Filter]) -> None:
    state = some_filter(form)
    before = state.pose_covariance()
    state.add(np.array([2.0, 0.3]), NOISE)
    assert np.allclose(state.pose_covariance(), before)


@pytest.mark.parametrize("form", FORMS)
def test_landmarks_that_are_one_become_one(form: type[Filter]) -> None:
    state = form()
    state.add(np.array([2.0, 0.3]), 1e-2 * np.eye(2))
    state.predict(Increment(Pose(0.2, 0.0, 0.1), 1e-3 * np.eye(3)))
    state.add(expected(state.pose, state.places)[0][0] + 0.03, 1e-3 * np.eye(2))
    spread = float(np.trace(state.place_covariances()[0]))
    difference, _ = state.apart(0, 1)
    state.join(np.array([0]), np.array([1]))
    assert len(state.places) == 1
    assert np.trace(state.place_covariances()[0]) < spread
    assert 0 < np.hypot(*difference) < 0.15


@pytest.mark.parametrize("form", FORMS)
def test_forgetting_a_landmark_leaves_the_others_as_they_are(form: type[Filter]) -> None:
    state = some_filter(form)
    places, spreads, pose = state.places, state.place_covariances(), state.pose_covariance()
    state.drop(1)
    assert np.allclose(state.places, places[[0, 2, 3]])
    assert np.allclose(state.place_covariances(), spreads[[0, 2, 3]])
    assert np.allclose(state.pose_covariance(), pose)


@pytest.mark.parametrize("form", FORMS)
def test_a_hundred_landmarks_stay_positive_definite(form: type[Filter]) -> None:
    rng, state = np.random.default_rng(0), form()
    for _ in range(100):
        state.add(np.array([rng.uniform(0.5, 6), rng.uniform(-3, 3)]), 1e-3 * np.eye(2))
    for _ in range(60):
        state.predict(Increment(Pose(0.05, 0.0, 0.03), np.diag([1e-5, 1e-5, 1e-5])))
        indices = rng.choice(100, 6, replace=False)
        readings = expected(state.pose, state.places[indices])[0] + rng.normal(0, 0.02, (6, 2))
        correct(state, indices, readings, np.repeat(4e-4 * np.eye(2)[None], 6, 0))
    dense = state.covariance.dense()
    assert np.linalg.eigvalsh(dense).min() > -1e-12 * np.abs(dense).max()
