import math

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from core.calibration import homography
from core.calibration.camera import bundle_adjustment
from core.calibration.camera.bundle_adjustment import BundleSolution, Corners
from core.calibration.levenberg_marquardt import Linearisation, descend, minimise
from core.calibration.practice import BoardPlacement
from core.calibration.projection import PAPER, Poses, linearise, project, vector_of
from core.message import Array
from core.optics import TABLE_3, CameraModel
from tests.core.calibration.seen_boards import BOARD, SIZE, some_corners, some_poses

PLAIN = CameraModel(width=320, height=256, fx=301.5, fy=303.2, cx=159.5, cy=127.5)


def test_homographies_of_an_undistorted_camera_are_exact() -> None:
    poses = some_poses(6)
    pixels = project(vector_of(PLAIN), poses, BOARD.points)
    first = homography.start(BOARD.points, pixels, SIZE)
    assert first.focal_known
    assert np.allclose(first.camera[:2], (PLAIN.fx, PLAIN.fy), rtol=1e-6)
    assert np.allclose(first.poses.rotations, poses.rotations, atol=1e-6)
    assert np.allclose(first.poses.translations, poses.translations, atol=1e-6)


def test_frontal_views_do_not_tell_the_focal_length() -> None:
    poses = some_poses(6, how=BoardPlacement(most_tilt=0.0))
    assert not homography.start(BOARD.points, project(vector_of(PLAIN), poses, BOARD.points), SIZE).focal_known


def test_every_start_is_in_front_of_the_camera_even_for_scrambled_corners() -> None:
    rng = np.random.default_rng(0)
    pixels = project(vector_of(PLAIN), some_poses(20), BOARD.points)
    scrambled = np.stack([view[rng.permutation(len(view))] for view in pixels])
    poses = homography.board_poses(BOARD.points, scrambled, vector_of(PLAIN))
    assert poses.points(BOARD.points)[..., 2].min() > 0


def test_the_solution_equals_opencv_to_six_digits_with_its_standard_deviations() -> None:
    corners, _ = some_corners(15, noise=0.2, seed=4)
    first = homography.start(corners.points, corners.pixels, SIZE)
    begun = BundleSolution(
        first.camera, bundle_adjustment.refine_poses(corners, BundleSolution(first.camera, first.poses))
    )
    ours, _ = bundle_adjustment.rescue(corners, bundle_adjustment.refine(corners, begun, PAPER))
    ours = bundle_adjustment.refine(corners, ours, PAPER)
    shown = [BOARD.points.astype(np.float32)] * 15
    told = [view.astype(np.float32) for view in corners.pixels]
    theirs = cv2.calibrateCameraExtended(shown, told, SIZE, None, None, flags=cv2.CALIB_FIX_K3)
    matrix, distortion, sds = theirs[1], theirs[2].ravel(), theirs[5].ravel()
    expected = [matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2], *distortion[:4]]
    noise = bundle_adjustment.noise(corners, ours, PAPER)
    spread = np.linalg.inv(bundle_adjustment.information(corners, ours, PAPER).sum(axis=0))
    assert np.allclose(ours.camera[:8], expected, rtol=1e-4, atol=1e-6)
    assert np.allclose(noise * np.sqrt(np.diag(spread)), sds[:8], rtol=2e-3)


def test_eliminating_the_poses_gives_the_covariance_of_the_whole_problem() -> None:
    corners, truth = some_corners(4, noise=0.0)
    linear = linearise(truth.camera, truth.poses, corners.points)
    rows = linear.by_camera.shape[1]
    whole = np.zeros((4 * rows, 8 + 24))
    for view in range(4):
        whole[view * rows : (view + 1) * rows, :8] = linear.by_camera[view, :, :8]
        whole[view * rows : (view + 1) * rows, 8 + 6 * view : 14 + 6 * view] = linear.by_pose[view]
    dense = np.linalg.inv(whole.T @ whole)[:8, :8]
    schur = np.linalg.inv(bundle_adjustment.information(corners, truth, PAPER).sum(axis=0))
    assert np.allclose(schur, dense, rtol=1e-6, atol=1e-12 * np.abs(dense).max())


def test_the_mirrored_pose_is_the_other_solution_of_the_plane_problem() -> None:
    poses = some_poses(8, seed=5, how=BoardPlacement(nearest=0.7, farthest=0.9, least_tilt=0.3))
    pixels = project(vector_of(PLAIN), poses, BOARD.points)
    seen = Corners(BOARD.points, pixels, np.ones(pixels.shape[:2], bool))
    other = bundle_adjustment.mirrored(poses, BOARD.centre)
    other = bundle_adjustment.refine_poses(seen, BundleSolution(vector_of(PLAIN), other), steps=40)
    for view in range(8):
        told = cv2.solvePnPGeneric(BOARD.points, pixels[view], PLAIN.matrix, None, flags=cv2.SOLVEPNP_IPPE)
        angles: list[float] = []
        for turn, shift in zip(told[1], told[2], strict=True):
            turn, _ = cv2.solvePnPRefineLM(BOARD.points, pixels[view], PLAIN.matrix, None, turn.copy(), shift.copy())
            theirs = Rotation.from_rotvec(turn.ravel()).as_matrix()
            angles.append(Rotation.from_matrix(theirs.T @ other.rotations[view]).magnitude())
        assert min(angles) < np.deg2rad(0.5)
        assert Rotation.from_matrix(poses.rotations[view].T @ other.rotations[view]).magnitude() > np.deg2rad(10)


def test_a_board_turned_over_is_turned_back() -> None:
    corners, truth = some_corners(12, noise=0.1, how=BoardPlacement(least_tilt=0.3))
    wrong = bundle_adjustment.mirrored(truth.poses, BOARD.centre)
    rotations, translations = truth.poses.rotations.copy(), truth.poses.translations.copy()
    rotations[3], translations[3] = wrong.rotations[3], wrong.translations[3]
    begun = BundleSolution(
        truth.camera,
        bundle_adjustment.refine_poses(
            corners,
            BundleSolution(truth.camera, truth.poses._replace(rotations=rotations, translations=translations)),
        ),
    )
    rescued, turned = bundle_adjustment.rescue(corners, begun)
    assert turned[3] and turned.sum() == 1
    assert np.allclose(rescued.poses.rotations[3], truth.poses.rotations[3], atol=0.05)


def test_a_view_without_corners_tells_nothing() -> None:
    corners, truth = some_corners(5, noise=0.1)
    used = corners.used.copy()
    used[2] = False
    told = bundle_adjustment.information(corners._replace(used=used), truth, PAPER)
    assert np.allclose(told[2], 0) and np.all(np.isfinite(told))


def test_levenberg_marquardt_finds_the_bottom_of_a_curved_valley() -> None:
    def rosenbrock(place: Array) -> tuple[Array, Array]:
        x, y = place
        return np.array([10 * (y - x * x), 1 - x]), np.array([[-20 * x, 10.0], [-1.0, 0.0]])

    fit = minimise(rosenbrock, np.array([-1.2, 1.0]), lambda place, step: place + step, iterations=200)
    assert np.allclose(fit.state, (1, 1), atol=1e-6)


def parabola(bottom: float, steps: float) -> tuple[Linearisation[float, float], list[float], int]:
    """Descend (x - bottom)² with steps too long by the factor `steps`; also count the evaluations."""
    evaluated = 0
    dampings: list[float] = []

    def at(x: float) -> Linearisation[float, float]:
        nonlocal evaluated
        evaluated += 1
        return Linearisation(x, bottom - x, math.inf if abs(x) > 9 else (x - bottom) ** 2)

    def advance(x: float, ahead: float, damping: float) -> tuple[float, float]:
        dampings.append(damping)
        return x + steps * ahead / (1 + damping), ahead**2

    return descend(at, advance, 0.0, iterations=40, close=1e-12, hopeless=1e6), dampings, evaluated


def test_steps_that_are_too_long_are_damped_until_they_help() -> None:
    found, dampings, _ = parabola(2.0, 50.0)
    assert math.isclose(found.state, 2.0, abs_tol=1e-5)
    assert max(dampings) >= 10 and min(dampings) >= 1e-9


def test_a_start_that_is_the_solution_is_evaluated_once() -> None:
    found, _, evaluated = parabola(0.0, 1.0)
    assert found.state == 0.0 and evaluated == 1


def test_a_descent_keeps_away_from_a_state_that_is_not_admissible() -> None:
    found, _, _ = parabola(12.0, 1.0)
    assert math.isfinite(found.cost) and 0 < found.state <= 9


def test_a_descent_ends_where_no_damping_helps() -> None:
    found, dampings, evaluated = parabola(1.0, -1.0)
    assert found.state == 0.0
    assert evaluated == len(dampings) + 1 < 41 and dampings[-1] <= 1e6 < 10.001 * dampings[-1]


def test_every_pose_is_refined_as_if_it_were_alone() -> None:
    corners, truth = some_corners(6, noise=0.2, seed=3)
    off = truth.poses.moved(np.random.default_rng(1).normal(0, 0.05, (6, 6)))
    hopeless = Poses(off.rotations, off.translations * np.where(np.arange(6) == 2, 40.0, 1.0)[:, None])
    start = BundleSolution(truth.camera, hopeless)
    together = bundle_adjustment.refine_poses(corners, start)
    for view in range(6):
        one = slice(view, view + 1)
        alone = bundle_adjustment.refine_poses(corners.take(one), BundleSolution(truth.camera, hopeless.take(one)))
        assert np.allclose(together.translations[view], alone.translations[0], atol=1e-12)
        if view != 2:
            assert np.allclose(alone.translations[0], truth.poses.translations[view], atol=0.01)


def test_the_camera_of_table_3_is_found_from_perfect_corners() -> None:
    corners, truth = some_corners(8, noise=0.0, seed=7)
    first = homography.start(corners.points, corners.pixels, SIZE)
    begun = BundleSolution(
        first.camera, bundle_adjustment.refine_poses(corners, BundleSolution(first.camera, first.poses))
    )
    begun, _ = bundle_adjustment.rescue(corners, begun, ratio=1.0)
    found = bundle_adjustment.refine(corners, begun, PAPER)
    assert np.allclose(found.camera, vector_of(TABLE_3), atol=1e-3)
    assert np.allclose(found.poses.translations, truth.poses.translations, atol=1e-5)
