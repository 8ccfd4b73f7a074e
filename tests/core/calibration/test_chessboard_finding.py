import cv2
import numpy as np
import pytest

from core.calibration.board.board import Board
from core.calibration.board.chessboard import board_by_hand, find_board, glimpse, half_window, oriented, sample
from core.calibration.board.quality import judge, off_grid, why_none
from core.calibration.practice import BoardPlacement, ImageExposure, picture
from core.calibration.projection import Poses, project, vector_of
from core.errors import BadInput
from core.message import Array
from core.optics import TABLE_3, CameraModel
from tests.core.calibration.seen_boards import BOARD, some_poses

FACING = Poses(np.eye(3)[None], np.array([[-0.12, -0.075, 0.42]]))
WIDE = CameraModel(width=640, height=480, fx=560, fy=560, cx=320, cy=240, k1=-0.25, k2=0.08)


def reason_of(grey: np.ndarray, board: Board) -> str:
    return str(why_none(grey, board))


def shot(poses: Poses = FACING, board: Board = BOARD, exposure: ImageExposure | None = None, seed: int = 0) -> Array:
    return picture(np.random.default_rng(seed), TABLE_3, poses, board, exposure)


def true_corners(poses: Poses = FACING) -> Array:
    return project(vector_of(TABLE_3), poses, BOARD.points)[0]


def test_corners_are_found_to_a_tenth_of_a_pixel_in_the_boards_own_order() -> None:
    poses = some_poses(8, seed=3, how=BoardPlacement(nearest=0.3, farthest=0.6, margin=12))
    found = 0
    for number in range(8):
        one = poses.take(slice(number, number + 1))
        view = find_board(shot(one), BOARD)
        if view is not None:
            found += 1
            assert np.sqrt(np.mean((view.corners - true_corners(one)) ** 2)) < 0.15
    assert found >= 7


def test_the_order_starts_at_the_dark_square_whichever_way_up_the_board_is() -> None:
    half_turn = Poses(np.diag([-1.0, -1.0, 1.0])[None], np.array([[0.12, 0.075, 0.42]]))
    for poses in (FACING, half_turn):
        view = find_board(shot(poses), BOARD)
        assert view is not None
        assert np.allclose(view.corners, true_corners(poses), atol=0.5)


def test_order_is_restored_from_any_order_of_the_detector() -> None:
    grey, corners = shot(), true_corners()
    grid = corners.reshape(6, 9, 2)
    for told in (grid[::-1, ::-1], grid[:, ::-1], grid[::-1]):
        assert np.allclose(oriented(grey, told.reshape(-1, 2), BOARD), corners)


TURNED = Poses(cv2.Rodrigues(np.array([0.35, -0.3, 0.2]))[0][None], np.array([[-0.12, -0.06, 0.45]]))


@pytest.mark.parametrize("poses", [FACING, TURNED], ids=["facing", "turned"])
@pytest.mark.parametrize("order", [(0, 1, 2, 3), (2, 0, 3, 1), (3, 2, 1, 0)])
def test_four_extreme_corners_by_hand_give_all_of_a_board_that_is_not_found(
    poses: Poses, order: tuple[int, ...]
) -> None:
    """A thumb over a crossing hides the board from the finder; the hand is up to three pixels off."""
    true = true_corners(poses)
    grey = cv2.circle(shot(poses).copy(), np.rint(true[22]).astype(int).tolist(), 12, 127, -1)
    assert find_board(grey, BOARD) is None
    marked = true[[0, 8, 53, 45]][list(order)] + np.random.default_rng(4).uniform(-3, 3, (4, 2))
    view = board_by_hand(grey, BOARD, marked)
    off = np.linalg.norm(view.corners - true, axis=1)
    assert np.median(off) < 0.15 and np.delete(off, 22).max() < 1.0 and off[22] < 4
    assert judge(grey, view, BOARD).refusals == ()


@pytest.mark.parametrize(
    ("marked", "sentence"),
    [
        ([[10, 10], [200, 10], [200, 10], [10, 200]], "quadrilateral"),
        ([[10, 10], [200, 10], [60, 60], [10, 200]], "quadrilateral"),
        ([[50, 50]] * 4, "quadrilateral"),
        ([[10, 10], [900, 10], [200, 200], [10, 200]], "within the picture"),
        ([[10, 10], [np.nan, 10], [200, 200], [10, 200]], "within the picture"),
    ],
)
def test_corners_by_hand_that_cannot_be_a_board_s_are_refused(marked: list[list[float]], sentence: str) -> None:
    with pytest.raises(BadInput, match=sentence):
        board_by_hand(shot(), BOARD, np.array(marked, float))


def test_a_live_picture_shows_the_board_where_it_was_even_when_the_glance_misses_it() -> None:
    far = Poses(np.eye(3)[None], np.array([[-0.12, -0.075, 1.0]]))
    grey = picture(np.random.default_rng(0), WIDE, far, BOARD)
    true = project(vector_of(WIDE), far, BOARD.points)[0]
    view = glimpse(grey, BOARD, last=true + 3, thorough=False)
    assert view is not None and np.abs(view.corners - true).max() < 0.5


def test_no_board_is_seen_where_there_is_none() -> None:
    rng = np.random.default_rng(0)
    clutter = cv2.GaussianBlur(rng.integers(0, 255, (256, 320)).astype(np.uint8), (0, 0), 3)
    for grey in (clutter, np.full((256, 320), 128, np.uint8), rng.integers(0, 255, (256, 320)).astype(np.uint8)):
        assert find_board(grey, BOARD) is None
        assert glimpse(grey, BOARD) is None
        assert "I see no 9x6 board" in reason_of(grey, BOARD) or "contrast" in reason_of(grey, BOARD)


def test_a_large_picture_is_searched_small_and_refined_at_full_size() -> None:
    large = CameraModel(width=2560, height=2048, fx=2412, fy=2426, cx=1247, cy=1117, k1=-0.43, k2=0.24)
    small = picture(np.random.default_rng(0), WIDE, FACING, BOARD)
    grey = cv2.resize(small, None, fx=4, fy=4, interpolation=cv2.INTER_CUBIC)
    view = find_board(grey, BOARD)
    true = (project(vector_of(WIDE), FACING, BOARD.points)[0] + 0.5) * 4 - 0.5
    assert view is not None and np.abs(view.corners - true).max() < 1.5
    assert large.width == grey.shape[1]


def test_the_window_never_reaches_the_next_corner() -> None:
    assert [half_window(spacing) for spacing in (3, 6.5, 21.8, 37, 500)] == [2, 2, 7, 10, 10]


def test_squares_counted_for_corners_are_noticed() -> None:
    reason = reason_of(shot(), Board(columns=10, rows=7, square=0.03))
    assert "9x6 inner corners" in reason and "squares instead" in reason


@pytest.mark.parametrize("entered", ["8x6", "9x5", "10x6", "9x7"])
def test_one_corner_too_few_or_too_many_is_noticed(entered: str) -> None:
    board = Board.parse(entered, 0.03)
    grey = shot()
    view = find_board(grey, board)
    if view is None:
        assert "9x6 inner corners" in reason_of(grey, board)
    else:
        assert "more inner corners than entered" in judge(grey, view, board).refusals[0]


def test_a_sharp_view_has_nothing_against_it() -> None:
    view = find_board(shot(), BOARD)
    assert view is not None
    quality = judge(shot(), view, BOARD)
    assert quality.refusals == () and quality.warnings == () and quality.sharpness < 5


@pytest.mark.parametrize(
    "exposure", [ImageExposure(motion=10), ImageExposure(blur=3.2)], ids=["moved along the rows", "unfocused"]
)
def test_a_blurred_view_is_refused_in_words(exposure: ImageExposure) -> None:
    grey = shot(exposure=exposure)
    view = find_board(grey, BOARD)
    assert view is not None and "Blurred" in judge(grey, view, BOARD).refusals[0]


def test_a_corner_at_the_rim_is_refused_and_the_side_is_named() -> None:
    left = Poses(np.eye(3)[None], np.array([[-0.236, -0.075, 0.42]]))
    assert 2 < true_corners(left)[:, 0].min() < 8
    view = find_board(shot(left), BOARD)
    assert view is not None and "left rim" in judge(shot(left), view, BOARD).refusals[0]


def test_the_smooth_grid_names_the_corner_that_was_moved() -> None:
    rng = np.random.default_rng(0)
    named = 0
    for number in range(20):
        corners = true_corners() + rng.normal(0, 0.1, (54, 2))
        wrong = int(rng.integers(54))
        corners[wrong] += 3 * np.array([np.cos(number), np.sin(number)])
        named += int(np.argmax(off_grid(corners, BOARD, (256, 320))) == wrong)
    assert named == 20


def test_lens_distortion_alone_is_smooth() -> None:
    assert off_grid(true_corners(), BOARD, (256, 320)).max() < 0.6


def test_darkness_and_flatness_are_told_apart() -> None:
    assert "too dark" in reason_of(np.full((256, 320), 20, np.uint8), BOARD)
    assert "no contrast" in reason_of(np.full((256, 320), 200, np.uint8), BOARD)


def test_sampling_interpolates_and_ends_at_the_rim() -> None:
    grey = np.arange(100, dtype=np.uint8).reshape(10, 10)
    levels = sample(grey, np.array([[2.5, 3.0], [0.0, 0.0], [-1.0, 2.0]]))
    assert levels[0] == pytest.approx(32.5, abs=0.51) and levels[1] == 0 and np.isnan(levels[2])


@pytest.mark.parametrize("text", ["9", "9x", "x6", "9x6x2", "2x6", "99x99", "a9x6"])
def test_a_board_that_makes_no_sense_is_refused(text: str) -> None:
    with pytest.raises(BadInput):
        Board.parse(text, 0.03)


@pytest.mark.parametrize("square", [0.0, -0.03, 30.0, float("nan")])
def test_a_square_that_makes_no_sense_is_refused(square: float) -> None:
    with pytest.raises(BadInput):
        Board.parse("9x6", square)


@pytest.mark.parametrize("entered", [(7, 7), (5, 4), (12, 9)])
def test_a_board_of_any_other_size_is_named(entered: tuple[int, int]) -> None:
    told = why_none(shot(), Board(columns=entered[0], rows=entered[1], square=0.03))
    assert told.seen == "9x6" and "This looks like 9x6, use it" in str(told)


def test_a_negative_board_and_squares_that_stand_apart_are_named() -> None:
    assert "light on dark" in reason_of(255 - shot(), BOARD)
    apart = np.full((480, 640), 225, np.uint8)
    for row, column in np.ndindex(7, 8):
        apart[60 + 50 * row : 60 + 50 * row + 28, 110 + 52 * column : 110 + 52 * column + 28] = 30
    assert "touch at their corners" in reason_of(apart, BOARD)


def test_a_chessboard_of_which_a_row_is_out_of_sight_is_not_said_to_be_of_separate_squares() -> None:
    cut = shot()
    cut[: cut.shape[0] // 3] = 120
    assert "touch at their corners" not in reason_of(cut, BOARD)


def test_a_lens_whose_middle_is_not_the_pictures_is_smooth_too() -> None:
    cut = CameraModel(width=700, height=600, fx=533, fy=533, cx=402, cy=334, k1=-0.29, k2=0.1)
    for turn in np.linspace(-0.5, 0.5, 5):
        tilted = cv2.Rodrigues(np.array([turn, -turn, 0.1]))[0][None]
        corners = project(vector_of(cut), Poses(tilted, np.array([[-0.25, -0.15, 0.35]])), BOARD.points)[0]
        assert off_grid(corners, BOARD, (600, 700)).max() < 0.6


def test_a_board_that_leaves_the_picture_is_not_told_to_be_a_smaller_one() -> None:
    spacing = TABLE_3.fx * BOARD.square / 0.42
    right = Poses(np.eye(3)[None], np.array([[0.075 - 0.03, -0.075, 0.42]]))
    grey = shot(right)
    last = true_corners(right)[:, 0].max()
    grey = np.ascontiguousarray(grey[:, : int(last - spacing / 2)])  # without the last column of corners
    assert find_board(grey, BOARD) is None
    assert why_none(grey, BOARD).seen == ""


def test_a_blurred_board_that_only_its_negative_shows_is_called_blurred() -> None:
    assert "Blurred" in reason_of(cv2.GaussianBlur(255 - shot(), (0, 0), 3.5), BOARD)
