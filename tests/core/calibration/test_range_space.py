import numpy as np
import pytest

from core.calibration.laser.plane_pairs import (
    Guess,
    Pair,
    PlanePair,
    PointPair,
    chi_squares,
    residuals_of,
    stack,
    whitening,
)
from core.calibration.laser.planes import Plane, board_pose, plane_of
from core.calibration.laser.range_lines import fit_ranges, unit_rays
from core.calibration.practice import BoardPlacement, held, seen
from core.calibration.projection import Poses
from core.errors import BadInput
from core.message import Array
from core.optics import TABLE_3
from tests.core.calibration.rooms_to_practise import a_room, pair_of


def some_pairs() -> tuple[list[Pair], Guess]:
    """Boards, an edge's corner, and a lonely beam."""
    room = a_room(1)
    pairs: list[Pair] = [pair_of(room, shot) for shot in room.shots(4, 5)]
    plane = pairs[0].plane
    lonely = fit_ranges(np.array([[0.9, 0.3, 0.316]]) / np.linalg.norm([0.9, 0.3, 0.316]), np.array([0.8]), 0.01)
    pairs.insert(1, PointPair(plane=plane, point=np.array([0.7, 0.1, 0.02]), covariance=1e-4 * np.eye(3)))
    pairs.append(PlanePair(plane=plane, ranges=lonely))
    truth = room.laser_from_camera
    return pairs, Guess(truth.rotation, truth.translation + 0.02, 0.005, 1.01)


def test_derivatives_of_all_pairs_equal_finite_differences() -> None:
    pairs, guess = some_pairs()
    every = stack(pairs)
    model = residuals_of(every, whitening(every, guess))
    told = model(guess)[1]
    for column in range(8):
        step = np.zeros(8)
        step[column] = 1e-6
        difference = (model(guess.moved(step))[0] - model(guess.moved(-step))[0]) / 2e-6
        assert np.allclose(told[:, column], difference, rtol=1e-4, atol=1e-5 * max(1.0, np.abs(difference).max()))


def test_a_flat_scan_of_a_plane_gives_that_plane_within_its_own() -> None:
    rays = unit_rays(np.linspace(-0.3, 0.4, 60))
    q = np.array([0.9, 0.35, 0.0])
    fit = fit_ranges(rays, 1 / (rays @ q), 0.01)
    assert np.allclose(fit.q, q) and fit.basis.shape == (3, 2) and np.allclose(fit.residuals, 0)


def test_one_beam_tells_one_direction() -> None:
    fit = fit_ranges(np.array([[1.0, 0.0, 0.0]]), np.array([2.0]), 0.02)
    assert fit.basis.shape == (3, 1) and np.allclose(fit.q, (0.5, 0, 0))
    assert np.sqrt(fit.covariance[0, 0]) == pytest.approx(0.02 / 4)


def test_the_lines_covariance_is_its_scatter() -> None:
    rng = np.random.default_rng(0)
    rays, q = unit_rays(np.linspace(0.1, 0.6, 50)), np.array([1.2, -0.4, 0.0])
    fits = [fit_ranges(rays, 1 / (rays @ q) + rng.normal(0, 0.01, 50), 0.01) for _ in range(600)]
    scatter = np.cov(np.array([fit.basis.T @ fit.q for fit in fits]).T)
    assert np.allclose(np.sqrt(np.diag(scatter)), np.sqrt(np.diag(fits[0].covariance)), rtol=0.12)


def test_the_derivative_by_the_offset_is_the_shift_that_an_offset_makes() -> None:
    rays, q = unit_rays(np.linspace(-0.2, 0.5, 40)), np.array([1.1, 0.3, 0.0])
    ranges = 1 / (rays @ q)
    fit = fit_ranges(rays, ranges, 0.01)
    without = fit_ranges(rays, ranges - 0.004, 0.01)
    assert np.allclose(without.q, fit.q + 0.004 * fit.by_offset, atol=1e-4)


def test_a_line_without_beams_is_refused() -> None:
    with pytest.raises(BadInput):
        fit_ranges(np.empty((0, 3)), np.empty(0), 0.01)


def test_the_planes_covariance_is_its_scatter() -> None:
    rng = np.random.default_rng(0)
    board = a_room(0).board
    pose = held(rng, 1, TABLE_3, board, BoardPlacement(least_tilt=0.4))
    planes: list[Array] = []
    for _ in range(300):
        plane = board_pose(TABLE_3, board, seen(rng, TABLE_3, pose, board, 0.2)[0]).plane
        planes.append(np.append(plane.normal, plane.distance))
    told = board_pose(TABLE_3, board, seen(rng, TABLE_3, pose, board, 0.2)[0]).plane
    scatter = np.cov(np.array(planes).T)
    assert np.sqrt(np.trace(scatter)) == pytest.approx(np.sqrt(np.trace(told.covariance)), rel=0.3)


def test_a_plane_is_normal_times_distance_whichever_way_the_board_faces() -> None:
    for flip in (1.0, -1.0):
        pose = Poses(np.diag([1.0, flip, flip])[None], np.array([[0.1, 0.2, 0.8]]))
        plane = plane_of(pose, np.eye(6) * 1e-6)
        assert plane.distance == pytest.approx(0.8) and np.allclose(plane.normal, (0, 0, 1))


def test_residuals_of_the_truth_are_as_large_as_stated() -> None:
    values: list[float] = []
    for seed in range(8):
        room = a_room(seed, noise=0.02)
        pairs = [pair_of(room, shot) for shot in room.shots(10, 4)]
        truth = room.laser_from_camera
        values += chi_squares(stack(pairs), Guess(truth.rotation, truth.translation)).tolist()
    assert np.mean(values) == pytest.approx(2.0, abs=0.5)


def test_chi_squares_keep_the_order_of_mixed_pairs() -> None:
    pairs, guess = some_pairs()
    values = chi_squares(stack(pairs), guess)
    alone = [chi_squares(stack([pair]), guess)[0] for pair in pairs]
    assert np.allclose(values, alone)


def test_an_exact_plane_needs_no_beams_to_agree_with_itself() -> None:
    plane = Plane(normal=np.array([0.0, 0.0, 1.0]), distance=1.0, covariance=np.zeros((4, 4)))
    rays = unit_rays(np.linspace(-0.2, 0.2, 20))
    room = a_room(3)
    normal = room.laser_from_camera.rotation @ plane.normal
    near = plane.distance + normal @ room.laser_from_camera.translation
    pair = PlanePair(plane=plane, ranges=fit_ranges(rays, near / (rays @ normal), 0.01))
    truth = Guess(room.laser_from_camera.rotation, room.laser_from_camera.translation)
    assert chi_squares(stack([pair]), truth)[0] < 1e-12
