from collections.abc import Callable
from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from core.calibration.camera import bundle_adjustment
from core.calibration.camera.bundle_adjustment import BundleSolution
from core.calibration.camera.intrinsics import Calibration, calibrate
from core.calibration.camera.uncertainty import uncertainty_map
from core.calibration.practice import BoardPlacement, held, seen
from core.calibration.projection import PAPER, vector_of
from core.calibration.reports import camera_report
from core.errors import BadInput
from core.message import Array
from core.optics import TABLE_3, CameraModel
from tests.core.calibration.seen_boards import BOARD, SIZE, some_corners, views_of

GRID = (BOARD.rows, BOARD.columns, 2)


def shifted_a_square(corners: Array) -> Array:
    return np.roll(corners.reshape(GRID), 1, axis=1).reshape(-1, 2)


def shifted_a_corner(corners: Array) -> Array:
    return np.roll(corners, 1, axis=0)


def rows_swapped(corners: Array) -> Array:
    grid = corners.reshape(GRID).copy()
    grid[[1, 2]] = grid[[2, 1]]
    return grid.reshape(-1, 2)


def noisy(corners: Array) -> Array:
    return corners + np.random.default_rng(9).normal(0, 3, corners.shape)


def one_corner_off(corners: Array) -> Array:
    moved = corners.copy()
    moved[20] += (3.0, -2.0)
    return moved


@pytest.fixture(scope="module")
def clean() -> Calibration:
    return calibrate(views_of(some_corners(13, noise=0.15, seed=2)[0].pixels), BOARD, SIZE)


@pytest.mark.parametrize(
    "culprits", [(6,), pytest.param((0, 12), marks=pytest.mark.campaign)], ids=["middle", "ends"]
)
@pytest.mark.parametrize("fault", [shifted_a_square, shifted_a_corner, rows_swapped, noisy, one_corner_off])
def test_a_poisoned_view_is_named_and_does_not_move_the_focal_length(
    clean: Calibration, fault: Callable[[Array], Array], culprits: tuple[int, ...]
) -> None:
    corners, _ = some_corners(13, noise=0.15, seed=2)
    for culprit in culprits:
        pixels = corners.pixels.copy()
        pixels[culprit] = fault(pixels[culprit])
        told = calibrate(views_of(pixels), BOARD, SIZE)
        assert told.verdicts[culprit].reason
        assert [verdict.used for verdict in told.verdicts].count(False) <= 1
        assert abs(told.model.fx - clean.model.fx) < 1.5


def test_the_reason_says_what_is_wrong() -> None:
    corners, _ = some_corners(13, noise=0.15, seed=2)
    for fault, words in (
        (rows_swapped, "rows 2 and 3"),
        (shifted_a_square, "one square"),
        (one_corner_off, "row 3, column 3"),
    ):
        pixels = corners.pixels.copy()
        pixels[4] = fault(pixels[4])
        assert words in calibrate(views_of(pixels), BOARD, SIZE).verdicts[4].reason


def test_good_views_are_all_used_without_a_remark() -> None:
    corners, _ = some_corners(20, noise=0.1, seed=8)
    told = calibrate(views_of(corners.pixels), BOARD, SIZE)
    assert all(verdict.used and not verdict.reason for verdict in told.verdicts)
    assert told.warnings == ()


@pytest.mark.campaign
def test_reported_deviations_cover_the_truth_and_no_board_is_turned_over() -> None:
    inside, total = 0, 0
    for seed in range(25):  # eight values or more each: the sd of the share is 0.015, were they independent
        corners, truth = some_corners(20, noise=0.1, seed=100 + seed)
        told = calibrate(views_of(corners.pixels), BOARD, SIZE)
        off = np.array([getattr(told.model, name) for name in told.free]) - vector_of(TABLE_3)[: len(told.free)]
        inside += int(np.sum(np.abs(off) < 2 * np.sqrt(np.diag(told.covariance))))
        total += len(off)
        leaning = np.sum(told.poses.rotations[:, :, 2] * truth.poses.rotations[:, :, 2], axis=1)
        assert leaning.min() > np.cos(np.deg2rad(10))
    assert total >= 200 and 0.90 <= inside / total <= 0.99


def test_k3_is_taken_only_where_a_hold_out_says_so() -> None:
    curved = CameraModel(width=320, height=256, fx=301.0, fy=303.0, cx=160.0, cy=128.0, k1=-0.3, k2=0.1, k3=-0.6)
    rng = np.random.default_rng(3)
    how = BoardPlacement(nearest=0.22, farthest=0.5)
    for model, wanted in ((curved, True), (TABLE_3, False)):
        pixels = seen(rng, model, held(rng, 25, model, BOARD, how), BOARD, 0.05)
        told = calibrate(views_of(pixels), BOARD, SIZE)
        assert ("k3" in told.free) is wanted


@pytest.mark.parametrize("seeds", [range(1), pytest.param(range(4), marks=pytest.mark.campaign)], ids=len)
@pytest.mark.parametrize("tilt_deg", [5, 10])
def test_hardly_tilted_boards_give_a_fine_rms_and_an_honest_uncertainty(tilt_deg: float, seeds: range) -> None:
    how = BoardPlacement(most_tilt=np.deg2rad(tilt_deg))
    for seed in seeds:
        corners, _ = some_corners(15, noise=0.15, seed=200 + seed, how=how)
        told = calibrate(views_of(corners.pixels), BOARD, SIZE)
        assert told.rms < 0.25
        assert uncertainty_map(told).p95 > 0.5


def test_one_pose_of_the_board_shown_many_times_does_not_tell_the_camera() -> None:
    """A film of a board on a tripod: what the model misses is the same in all pictures, and does not average out."""
    corners, _ = some_corners(3, noise=0.0, seed=7)
    rng = np.random.default_rng(7)
    missed = rng.normal(0, 0.1, corners.pixels[0].shape)
    film = corners.pixels[0] + missed + rng.normal(0, 0.05, (12, *missed.shape))
    told = calibrate(views_of(film), BOARD, SIZE)
    assert "tilted alike in all pictures" in told.undecided or "do not decide" in told.undecided
    assert not calibrate(
        views_of(corners.pixels + 0.1 * rng.normal(size=corners.pixels.shape)), BOARD, SIZE
    ).undecided


def test_two_views_are_too_few() -> None:
    corners, _ = some_corners(2, noise=0.1)
    with pytest.raises(BadInput, match="too few"):
        calibrate(views_of(corners.pixels), BOARD, SIZE)


def test_corners_of_another_board_are_refused() -> None:
    corners, _ = some_corners(4, noise=0.1)
    with pytest.raises(BadInput, match="54 corners"):
        calibrate(views_of(corners.pixels[:, :48]), BOARD, SIZE)


def test_four_hundred_views_are_solved_at_once() -> None:
    corners, _ = some_corners(400, noise=0.1, seed=11)
    told = calibrate(views_of(corners.pixels), BOARD, SIZE)
    assert abs(told.model.fx - TABLE_3.fx) < 4 * told.sds["fx"]
    assert told.sds["fx"] < 0.2


def test_the_boards_poses_and_their_deviations_are_those_of_opencv(clean: Calibration) -> None:
    report = camera_report(clean)
    _, _, _, rvecs, tvecs, _, deviations, _ = cv2.calibrateCameraExtended(
        [BOARD.points.astype(np.float32)] * len(clean.verdicts),
        list(clean.corners.pixels.astype(np.float32)[:, :, None]),
        SIZE,
        None,
        None,
        flags=cv2.CALIB_FIX_K3,
        criteria=(cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 100, 1e-12),
    )
    sds = deviations.reshape(-1, 6)
    for view, rvec, tvec, sd in zip(report["views"], rvecs, tvecs, sds, strict=True):
        pose = view["pose"]
        assert pose["tvec_m"] == pytest.approx(tvec.ravel(), abs=0.1 * sd[3:].min())
        assert pose["sd_translation_m"] == pytest.approx(sd[3:], rel=0.05)
        between = Rotation.from_rotvec(rvec.ravel()).inv() * Rotation.from_rotvec(pose["rvec_rad"])
        assert between.magnitude() < 0.1 * sd[:3].min()
        assert 0 < max(pose["sd_rotation_rad"]) < 0.05


def test_of_many_views_all_are_solved_though_only_some_begin() -> None:
    corners, truth = some_corners(130, noise=0.1, seed=7)
    pixels = corners.pixels.copy()
    pixels[101:104] = [rows_swapped(each) for each in pixels[101:104]]
    found = calibrate(views_of(pixels), BOARD, SIZE)
    assert np.flatnonzero(~found.used).tolist() == [101, 102, 103]
    some = corners.take(found.used)
    alone = bundle_adjustment.refine(some, BundleSolution(truth.camera, truth.poses.take(found.used)), PAPER)
    sds = np.sqrt(np.diag(found.covariance))
    assert np.all(np.abs(vector_of(found.model)[:8] - alone.camera[:8]) < 1e-3 * sds)


@pytest.mark.parametrize(
    ("square", "codes"), [(0.004, ["board.size"]), (0.012, []), (0.2, []), (0.3, ["board.size"])]
)
def test_a_board_whose_squares_are_in_another_unit_is_doubted(square: float, codes: list[str]) -> None:
    views = views_of(some_corners(13, noise=0.15, seed=2)[0].pixels)
    found = calibrate(views, replace(BOARD, square=square), SIZE)
    assert [one.code for one in found.faults if one.code.startswith("board.")] == codes
