"""What a bearing says of the state, against finite differences in both forms of the filter."""

import math

import numpy as np
import pytest

from core.geometry import Pose, wrap_all
from core.slam.bearings.geometry import coincide, crossed, ranged_then, remember, seen_now, seen_then
from core.slam.ekf.filter import Filter, Innovation
from core.slam.motion import Increment
from tests.core.slam.filter_states import FORMS, apart_by, slope, some_filter

EYE = Pose(0.04, -0.02, 0.3)


def with_points(form: type[Filter]):
    """A filter with a pose of the past and two points besides its landmarks, everything connected."""
    state = some_filter(form, landmarks=2)
    past = remember(state, EYE)
    state.predict(Increment(Pose(0.5, 0.1, 0.2), 1e-4 * np.eye(3)))
    state.settle()
    rows = np.zeros((2, state.covariance.size))
    points = [
        state.attach(np.array(place), rows[:, : state.covariance.size], 0.01 * np.eye(2)) for place in ((3.0, 1.0),)
    ]
    rows = np.zeros((2, state.covariance.size))
    points.append(state.attach(np.array((2.5, 1.4)), rows, 0.01 * np.eye(2)))
    count = state.covariance.size
    state.covariance.lift(0.02 * np.random.default_rng(5).normal(size=(count, count)))
    return state, past, points


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("kind", ["now", "then", "range", "coincide"])
def test_an_innovation_is_the_measurement_s_derivative_times_the_covariance(form: type[Filter], kind: str) -> None:
    state, past, points = with_points(form)

    def innovation(of: Filter) -> Innovation:
        if kind == "now":
            return seen_now(of, EYE, points, np.zeros(2))
        if kind == "then":
            return seen_then(of, past, points[0], 0.0)
        return ranged_then(of, past, points[0], 0.0) if kind == "range" else coincide(of, *points)

    def measured(error: np.ndarray) -> np.ndarray:
        off = innovation(state).residuals.ravel() - innovation(apart_by(state, error)).residuals.ravel()
        return wrap_all(off) if kind in ("now", "then") else off

    jacobian = slope(measured, state.covariance.size)
    found, whole = innovation(state), state.covariance.dense()
    assert np.allclose(found.crossing, jacobian @ whole, atol=1e-5)
    assert np.allclose(found.state, jacobian @ whole @ jacobian.T, atol=1e-5)


@pytest.mark.parametrize("form", FORMS)
def test_a_crossing_errs_as_the_poses_from_which_it_is_seen(form: type[Filter]) -> None:
    state, first, _ = with_points(form)
    second = remember(state, EYE)
    views = ((first, 0.5), (second, 0.9))

    def place(of: Filter) -> np.ndarray:
        found = crossed(of, views, 0.0)
        assert found is not None
        return found[0]

    start = crossed(state, views, 0.0)
    assert start is not None
    centre, rows, own = start
    size = state.covariance.size
    moved = slope(lambda error: place(apart_by(state, error)), size)
    turn = np.zeros(size)
    turn[2] = 1.0
    error = moved - np.outer(state.turning(centre[None])[0], turn)  # as the form measures a point's error
    whole = state.covariance.dense()
    assert np.allclose(rows, error @ whole, atol=1e-5)
    assert np.allclose(own, error @ whole @ error.T, atol=1e-5)


@pytest.mark.parametrize("form", FORMS)
def test_a_landmark_that_joins_leaves_the_attached_points_as_they_are(form: type[Filter]) -> None:
    state, _, points = with_points(form)
    before = state.points[state.index_of(points[1])].copy()
    spread = coincide(state, *points).state
    index = state.add(np.array([2.0, 0.3]), 1e-4 * np.eye(2))
    assert index == 2 and len(state.places) == 3
    assert np.array_equal(state.points[state.index_of(points[1])], before)
    assert np.allclose(coincide(state, *points).state, spread)
    state.drop(0)
    assert np.allclose(coincide(state, *points).state, spread)
    state.detach(points[0])
    assert np.array_equal(state.points[state.index_of(points[1])], before)
    assert len(state.places) == 2 and state.covariance.size == 3 + 2 * len(state.points)


def test_a_pose_that_is_remembered_is_the_present_one() -> None:
    state = some_filter(FORMS[0])
    past = remember(state, EYE)
    eye, ahead = (state.points[state.index_of(point)] for point in (past.eye, past.ahead))
    here = state.pose @ EYE
    assert np.allclose(eye, (here.x, here.y))
    assert math.isclose(math.atan2(*(ahead - eye)[::-1]), here.heading)
