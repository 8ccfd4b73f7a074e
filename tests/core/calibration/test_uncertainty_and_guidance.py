import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from core.calibration.camera import bundle_adjustment
from core.calibration.camera.guidance import advise, candidates, clear, tilt_words, usual_camera
from core.calibration.camera.intrinsics import calibrate
from core.calibration.camera.session import bars, cells, measures
from core.calibration.camera.uncertainty import (
    MAP_COLUMNS,
    MAP_ROWS,
    map_pixels,
    sensitivity,
    uncertainty_map,
    view_information,
)
from core.calibration.practice import visible
from core.calibration.projection import PAPER, Poses, exponential, project, vector_of
from core.message import Array
from core.optics import TABLE_3, CameraModel
from tests.core.calibration.seen_boards import BOARD, SIZE, some_corners, some_poses, views_of


def rays(model: CameraModel, pixels: Array) -> Array:
    ideal = model.undistort((pixels - (model.cx, model.cy)) / (model.fx, model.fy))
    return np.column_stack((ideal, np.ones(len(ideal))))


def turned_error(found: CameraModel, around: Array) -> Array:
    """How far the found camera puts distant points from the truth, after the best turn over the corners seen."""
    there, aim = rays(TABLE_3, around), rays(found, around)
    units = [each / np.linalg.norm(each, axis=1, keepdims=True) for each in (aim, there)]
    turn = Rotation.align_vectors(units[0], units[1])[0].as_matrix()
    grid = rays(TABLE_3, map_pixels(TABLE_3)) @ turn.T
    placed = found.distort(grid[:, :2] / grid[:, 2:]) * (found.fx, found.fy) + (found.cx, found.cy)
    return np.linalg.norm(placed - map_pixels(TABLE_3), axis=1)


def test_the_map_tells_the_true_error() -> None:
    ratios: list[Array] = []
    for seed in range(12):
        corners, _ = some_corners(12, noise=0.2, seed=300 + seed)
        told = calibrate(views_of(corners.pixels), BOARD, SIZE)
        error = turned_error(told.model, corners.pixels.reshape(-1, 2))
        ratios.append(error / uncertainty_map(told).sd.ravel())
    within = np.mean(np.array(ratios) < 2.45)  # 95 % of a two-dimensional error, if equal along both axes
    assert within > 0.9
    assert 0.4 < np.sqrt(np.mean(np.array(ratios) ** 2)) < 1.6


def test_the_map_covers_the_picture() -> None:
    corners, _ = some_corners(8, noise=0.2)
    known = uncertainty_map(calibrate(views_of(corners.pixels), BOARD, SIZE))
    assert known.sd.shape == (MAP_ROWS, MAP_COLUMNS)
    assert tuple(known.pixels[0, 0]) == (0, 0) and tuple(known.pixels[-1, -1]) == (319, 255)
    assert known.median <= known.p95 <= known.worst


def test_a_turn_of_the_camera_is_no_error() -> None:
    told = sensitivity(TABLE_3, PAPER).by_camera
    centre = told.reshape(MAP_ROWS, MAP_COLUMNS, 2, 8)[MAP_ROWS // 2, MAP_COLUMNS // 2, 0, 2]
    assert abs(centre) < 0.6  # a shifted principal point moves the pixel by 1, most of which is a turn


def test_predicted_information_is_what_a_view_gives() -> None:
    corners, truth = some_corners(5, noise=0.0)
    predicted = view_information(truth.camera, truth.poses, BOARD.points, 0.3)
    assert np.allclose(predicted, bundle_adjustment.information(corners, truth, PAPER) / 0.09)


def test_each_advised_view_makes_the_picture_better_known() -> None:
    rng = np.random.default_rng(4)
    seen: list[Array] = []
    known: list[float] = []
    calibration = None
    for _ in range(8):
        advice = advise(BOARD, SIZE, calibration, np.array(seen).reshape(-1, 54, 2))
        pose = Poses(advice.rotation[None], advice.translation[None])
        for _ in range(200):
            leaning = exponential(rng.normal(0, np.deg2rad(3), (1, 3))) @ pose.rotations
            off = Poses(leaning, pose.translations + rng.normal(0, 0.02, (1, 3)))
            if visible(TABLE_3, off, BOARD, 4)[0]:
                break
        seen.append(project(vector_of(TABLE_3), off, BOARD.points)[0] + rng.normal(0, 0.2, (54, 2)))
        if len(seen) >= 4:
            calibration = calibrate(views_of(np.array(seen)), BOARD, SIZE)
            known.append(uncertainty_map(calibration).p95)
    assert known[-1] < 0.6 and known[-1] < known[0]


def test_every_candidate_is_in_the_picture_and_clear_enough_to_be_found() -> None:
    camera = usual_camera((640, 480))
    poses = candidates(camera, BOARD)
    assert len(poses.rotations) > 100
    assert visible(camera, poses, BOARD, 10).all() and clear(camera, poses, BOARD).all()


@pytest.mark.parametrize(
    ("about", "words"),
    [
        ((0.0, 0.6, 0.0), "left edge"),
        ((0.0, -0.6, 0.0), "right edge"),
        ((0.6, 0.0, 0.0), "bottom edge"),
        ((-0.6, 0.0, 0.0), "top edge"),
        ((0.4, -0.4, 0.0), "bottom right corner"),
        ((0.0, 0.0, 0.5), "facing the camera"),
    ],
)
def test_words_name_the_edge_that_is_farther_away(about: tuple[float, float, float], words: str) -> None:
    rotation = exponential(np.array([about]))[0]
    assert words in tilt_words(rotation, np.deg2rad(12))


def test_the_farther_edge_really_is_farther() -> None:
    rotation = exponential(np.array([[0.0, 0.6, 0.0]]))[0]
    left, right = (rotation @ np.array([x, 0.0, 0.0]) for x in (-1.0, 1.0))
    assert left[2] > right[2] and "left edge" in tilt_words(rotation, 0.1)


def test_measures_of_a_facing_board_in_the_middle() -> None:
    pose = Poses(np.eye(3)[None], np.array([[-0.12, -0.075, 0.5]]))
    plain = CameraModel(width=320, height=256, fx=300, fy=300, cx=159.5, cy=127.5)
    told = measures(project(vector_of(plain), pose, BOARD.points)[0], BOARD, SIZE)
    assert told.x == pytest.approx(0.5, abs=0.02) and told.y == pytest.approx(0.5, abs=0.02)
    assert told.skew == pytest.approx(0, abs=0.01) and 0 < told.size < 1


def test_bars_fill_up_and_cells_count_every_corner() -> None:
    pixels = [project(vector_of(TABLE_3), some_poses(15), BOARD.points)[number] for number in range(15)]
    spanned = bars([measures(corners, BOARD, SIZE) for corners in pixels])
    assert bars([]) == (0, 0, 0, 0) and all(0 < bar <= 1 for bar in spanned)
    assert cells(pixels, SIZE).shape == (6, 8) and cells(pixels, SIZE).sum() == 15 * 54
