"""Find a chessboard in a picture and its inner corners to a fraction of a pixel."""

import cv2
import numpy as np

from core.calibration.board.board import Board
from core.errors import BadInput
from core.message import Array, message

FLAGS = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE
QUICK = FLAGS | cv2.CALIB_CB_FAST_CHECK
HAND_ROUNDS = 3  # in which corners between those that were marked by hand are refined
MAX_HAND_MISFIT = 0.15  # of the smallest spacing: a corner that lies farther off the plane of most is laid there
SUBPIXEL_CRITERIA = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 30, 0.001)


# Thresholds of the search for the board.
GLANCE_WIDTH_PX = 320  # [pixel] width of the copy on which a live picture is glanced at first
SMALL_WIDTH_PX = 400  # [pixel] pictures up to this width are searched at twice their size: many more boards are found
PATIENT_SIDE_PX = 800  # [pixel] longest side up to which the search goes without the quick check; noise takes seconds
SEARCH_SIDE_PX = 1280  # [pixel] longest side in which corners are searched; finer pictures only refine
WINDOW_SHARE = 1 / 3  # of the smallest corner spacing: half-window of the sub-pixel refinement
MIN_WINDOW_PX = 2  # [pixel] of this half-window, at least
MAX_WINDOW_PX = 10  # [pixel] at most: a window that reaches the next corner pulls f away by up to 20 px
SEARCHED_SHARE = 0.4  # share of the board's extent that is searched around its last place
GLANCE_SPACING_PX = 16.0  # [pixel] between corners of the copy that is glanced at first: half a board takes 100 ms


@message
class BoardView:
    """A board in one picture."""

    corners: Array  # (N, 2) [pixel], row by row, clockwise, from the corner whose inner square is dark
    window: int  # [pixel] half-window of the refinement
    spacing: float  # [pixel] smallest distance of neighbouring corners


def find_board(grey: Array, board: Board) -> BoardView | None:
    """Grey picture (H, W) uint8 → the board in it, or None. For pictures that may take their time."""
    own, longest = working_scale(grey), max(grey.shape)
    if longest <= PATIENT_SIDE_PX:
        found = _search_at(grey, board, own, FLAGS)
    else:
        found = _search_at(grey, board, min(1.0, SEARCH_SIDE_PX / longest), QUICK)
        if found is None:
            found = _search_at(grey, board, PATIENT_SIDE_PX / longest, FLAGS)
    return None if found is None else _view(grey, found, board)


def board_by_hand(grey: Array, board: Board, extreme: Array) -> BoardView:
    """Grey picture (H, W) and the four extreme inner corners (4, 2) [pixel] in any order (figure 3) → the board.

    The corners between lie where a plane has them, give or take the lens; each is refined, and those that went wrong
    are laid among the others once more. Raises BadInput where the four are no quadrilateral in the picture.
    """
    height, width = grey.shape
    if not np.all((extreme >= -0.5) & (extreme <= (width - 0.5, height - 0.5))):
        raise BadInput("The four extreme corners must lie within the picture.")
    around = extreme - extreme.mean(axis=0)
    ring = extreme[np.argsort(np.arctan2(around[:, 1], around[:, 0]))].astype(np.float32)
    if not cv2.isContourConvex(ring.reshape(-1, 1, 2)) or cv2.contourArea(ring) < 1.0:
        raise BadInput("The four extreme corners must be the corners of a quadrilateral.")
    across, down = board.columns - 1.0, board.rows - 1.0
    ends = np.array([[0, 0], [across, 0], [across, down], [0, down]], np.float32)
    grid = board.points[:, :2] / board.square
    laid = [_through(cv2.getPerspectiveTransform(ends, np.roll(ring, turn, axis=0)), grid) for turn in (0, 1)]
    found = max(laid, key=lambda corners: _chequered(grey, corners, board))
    for _ in range(HAND_ROUNDS):
        refined = _refined(grey, found, board)[0]
        plane, agree = _plane(grid, refined, MAX_HAND_MISFIT * smallest_spacing(found, board))
        if plane is None:
            break
        found = np.where(agree.astype(bool), refined, _through(plane, grid))
    return _view(grey, found, board)


def _plane(grid: Array, pixels: Array, reach: float) -> tuple[Array | None, Array]:
    """The homography (3, 3) of most of the places (N, 2), None where there is none, and which are within reach."""
    return cv2.findHomography(grid, pixels, cv2.RANSAC, reach)


def _through(plane: Array, grid: Array) -> Array:
    """Places (N, 2) on the board, in squares → pixels (N, 2) by a homography (3, 3)."""
    return cv2.perspectiveTransform(grid.reshape(-1, 1, 2), np.asarray(plane, float)).reshape(-1, 2)


def _chequered(grey: Array, corners: Array, board: Board) -> float:
    """How far the inner squares alternate between dark and light [grey levels]."""
    shades, even = _squares(grey, corners.reshape(board.rows, board.columns, 2))
    return abs(float(np.nanmean(shades[even]) - np.nanmean(shades[~even])))


def _squares(grey: Array, grid: Array) -> tuple[Array, Array]:
    """Shades of the inner squares between corners (R, C, 2), and which of them are alike."""
    shades = sample(grey, (grid[:-1, :-1] + grid[1:, :-1] + grid[:-1, 1:] + grid[1:, 1:]) / 4)
    return shades, np.add.outer(np.arange(shades.shape[0]), np.arange(shades.shape[1])) % 2 == 0


def glimpse(grey: Array, board: Board, last: Array | None = None, *, thorough: bool = True) -> BoardView | None:
    """The same for a live picture: where the board was a moment ago, else after a glance at a small copy.

    `last`: corners (N, 2) [pixel] in the picture before. `thorough`: look at the whole picture when the glance, which
    misses far boards, sees nothing; ask for it now and then only, as it is slow where there is no board.
    """
    found = None if last is None else _search_around(grey, board, last)
    if found is None:
        scale = min(1.0, GLANCE_WIDTH_PX / grey.shape[1])
        if scale < 1 and search(_scaled(grey, scale), board, QUICK) is not None:
            found = _search_at(grey, board, min(1.0, PATIENT_SIDE_PX / max(grey.shape)), FLAGS)
        elif thorough:
            found = _search_at(grey, board, working_scale(grey), QUICK)
    return None if found is None else _view(grey, found, board)


def working_scale(grey: Array) -> float:
    """The scale at which boards in such a picture are found best."""
    return 2.0 if grey.shape[1] <= SMALL_WIDTH_PX else min(1.0, PATIENT_SIDE_PX / max(grey.shape))


def search(grey: Array, board: Board, flags: int) -> Array | None:
    """The classic detector: grey picture → corners (N, 2) [pixel], in any order, or None."""
    if min(grey.shape) < 3 * max(board.columns, board.rows):
        return None
    found, corners = cv2.findChessboardCorners(grey, (board.columns, board.rows), flags=flags)
    return corners.reshape(-1, 2).astype(float) if found else None


def half_window(spacing: float) -> int:
    """Smallest spacing of corners [pixel] → half-window [pixel] that cannot reach a neighbouring corner."""
    return int(np.clip(int(spacing * WINDOW_SHARE), MIN_WINDOW_PX, MAX_WINDOW_PX))


def smallest_spacing(corners: Array, board: Board) -> float:
    """Corners (N, 2) [pixel] → smallest distance of neighbours along rows and columns [pixel]."""
    grid = corners.reshape(board.rows, board.columns, 2)
    return float(min(np.linalg.norm(np.diff(grid, axis=axis), axis=2).min() for axis in (0, 1)))


def oriented(grey: Array, corners: Array, board: Board) -> Array:
    """Corners (N, 2) in the detector's order → row by row, clockwise, from the corner whose inner square is dark.

    A board with both counts odd or both even looks the same after half a turn; there the start stays as it was.
    """
    grid = corners.reshape(board.rows, board.columns, 2)
    along, down = grid[0, -1] - grid[0, 0], grid[-1, 0] - grid[0, 0]
    if along[0] * down[1] - along[1] * down[0] < 0:
        grid = grid[:, ::-1]
    shades, even = _squares(grey, grid)
    if not board.ambiguous and shades[even].mean() > shades[~even].mean():
        grid = grid[::-1, ::-1]
    return np.ascontiguousarray(grid.reshape(-1, 2))


def sample(grey: Array, pixels: Array) -> Array:
    """Grey levels at pixels (..., 2), interpolated; NaN outside the picture."""
    places = np.ascontiguousarray(pixels.reshape(-1, 1, 2), dtype=np.float32)
    levels = cv2.remap(grey, places, None, cv2.INTER_LINEAR)  # pyright: ignore[reportCallIssue,reportArgumentType]
    height, width = grey.shape
    inside = np.all((pixels >= 0) & (pixels <= (width - 1, height - 1)), axis=-1)
    return np.where(inside, levels.reshape(pixels.shape[:-1]).astype(float), np.nan)


def _view(grey: Array, found: Array, board: Board) -> BoardView:
    corners, window = _refined(grey, found, board)
    spacing = smallest_spacing(corners, board)
    return BoardView(corners=oriented(grey, corners, board), window=window, spacing=spacing)


def _refined(grey: Array, found: Array, board: Board) -> tuple[Array, int]:
    window = half_window(smallest_spacing(found, board))
    corners = np.ascontiguousarray(found.reshape(-1, 1, 2), dtype=np.float32)
    refined = cv2.cornerSubPix(grey, corners, (window, window), (-1, -1), SUBPIXEL_CRITERIA)
    return refined.reshape(-1, 2).astype(float), window


def _search_at(grey: Array, board: Board, scale: float, flags: int) -> Array | None:
    """Search in a scaled copy; corners in the pixels of the original."""
    if scale == 1.0:
        return search(grey, board, flags)
    copy = _scaled(grey, scale)
    found = search(copy, board, flags)
    return None if found is None else (_refined(copy, found, board)[0] + 0.5) / scale - 0.5


def _search_around(grey: Array, board: Board, last: Array) -> Array | None:
    low, high = last.min(axis=0), last.max(axis=0)
    reach = SEARCHED_SHARE * (high - low) + 16
    height, width = grey.shape
    left, top = np.maximum(low - reach, 0).astype(int)
    right, bottom = np.minimum(high + reach, (width, height)).astype(int)
    part = np.ascontiguousarray(grey[top:bottom, left:right])
    scale, gate = working_scale(grey), GLANCE_SPACING_PX / smallest_spacing(last, board)
    if gate < 0.8 * scale and search(_scaled(part, gate), board, QUICK) is None:
        return None
    found = _search_at(part, board, scale, QUICK)
    return None if found is None else found + np.array([left, top])


def _scaled(grey: Array, scale: float) -> Array:
    how = cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR
    return cv2.resize(grey, None, fx=scale, fy=scale, interpolation=how)
