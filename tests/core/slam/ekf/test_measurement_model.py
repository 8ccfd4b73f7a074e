import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.geometry import Pose, wrap, wrap_all
from core.slam.ekf.measurement_model import expected, place_of, residual, squared_distance

STEP = 1e-6
coordinate = st.floats(-5, 5)
angle = st.floats(-3.1, 3.1)


@given(coordinate, coordinate, angle, st.floats(0.2, 6), angle)
def test_a_landmark_stands_where_its_sighting_says(x: float, y: float, heading: float, r: float, phi: float) -> None:
    pose = Pose(x, y, heading)
    place, _ = place_of(pose, np.array([r, phi]))
    sightings, _ = expected(pose, place[None])
    assert sightings[0, 0] == pytest.approx(r)
    assert wrap(sightings[0, 1] - phi) == pytest.approx(0.0, abs=1e-9)


@given(coordinate, coordinate, angle, st.floats(0.3, 6), angle)
def test_both_jacobians_are_derivatives(x: float, y: float, heading: float, r: float, phi: float) -> None:
    pose, sighting = Pose(x, y, heading), np.array([r, phi])
    place, onto = place_of(pose, sighting)
    _, slopes = expected(pose, place[None])
    for axis in range(2):
        step = STEP * np.eye(2)[axis]
        moved = expected(pose, (place + step)[None])[0] - expected(pose, (place - step)[None])[0]
        moved[:, 1] = wrap_all(moved[:, 1])
        assert np.allclose(slopes[0][:, axis], moved[0] / (2 * STEP), atol=1e-6)
        changed = place_of(pose, sighting + step)[0] - place_of(pose, sighting - step)[0]
        assert np.allclose(onto[:, axis], changed / (2 * STEP), atol=1e-6)


def test_the_printed_equations_see_a_landmark_ahead_behind() -> None:
    """Why eq. 24 and 26 are not used as printed: robot minus landmark turns the bearing by half a turn."""
    sightings, _ = expected(Pose(1.0, 1.0, 0.0), np.array([[3.0, 1.0]]))
    assert sightings[0, 1] == pytest.approx(0.0)
    printed = np.arctan2(1.0 - 1.0, 1.0 - 3.0)
    assert abs(printed) == pytest.approx(np.pi)


def test_a_surprise_across_the_half_turn_is_small() -> None:
    off = residual(np.array([[1.0, 3.1]]), np.array([[1.0, -3.1]]))
    assert off[0, 1] == pytest.approx(6.2 - 2 * np.pi)


def test_squared_distance_is_mahalanobis() -> None:
    rng = np.random.default_rng(0)
    roots = rng.normal(size=(7, 2, 2))
    spreads = roots @ roots.transpose(0, 2, 1) + 0.1 * np.eye(2)
    offs = rng.normal(size=(7, 2))
    distances, sizes = squared_distance(offs, spreads)
    assert np.allclose(distances, [e @ np.linalg.solve(s, e) for e, s in zip(offs, spreads, strict=True)])
    assert np.allclose(sizes, np.log(np.linalg.det(spreads)))
