"""Explain why a view does not fit, for the person who took it."""

import numpy as np

from core.calibration import homography
from core.calibration.board.board import Board
from core.calibration.camera import bundle_adjustment
from core.calibration.camera.bundle_adjustment import BundleSolution, Corners
from core.message import Array

MAX_ERROR_RATIO = 6.0  # a corner within this many typical errors agrees with the camera
ODD_ROW_SDS = 6.0  # a whole row or column off by this many standard deviations of its mean is reported
MIN_AGREEING_SHARE = 0.8  # share of the corners that has to agree before the rest is called misplaced


def accuse(pixels: Array, number: int, solution: BundleSolution, board: Board, typical: float) -> tuple[str, bool]:
    """Corners (N, 2) of view `number`, of which some or all were left out → what is wrong with them, and whether that
    is certain whatever the camera is.
    """
    pose = solution.poses.take(slice(number, number + 1))
    lengths = np.linalg.norm(
        bundle_adjustment.errors(_one(board, pixels), BundleSolution(solution.camera, pose))[0], axis=1
    )
    wrong = lengths > MAX_ERROR_RATIO * typical
    spacing = float(np.median(np.linalg.norm(np.diff(pixels.reshape(board.rows, board.columns, 2), axis=1), axis=2)))
    if lengths.max() > spacing / 2:
        for order, words in _orders(board):
            if _error(pixels[order], board, solution.camera) < MAX_ERROR_RATIO * typical:
                return words, True
    if wrong.mean() <= 1 - MIN_AGREEING_SHARE:
        worst = int(np.argmax(lengths))
        row, column = divmod(worst, board.columns)
        others = f" and {wrong.sum() - 1} more are off" if wrong.sum() > 1 else " is off"
        return f"the corner in row {row + 1}, column {column + 1}{others}, by up to {lengths[worst]:.1f} px", True
    words = (
        f"its corners miss the camera model by {np.sqrt(np.mean(lengths**2)):.1f} px where the others miss by "
        f"{typical:.1f}: blurred, moved during the exposure, corners misplaced, or a bent board"
    )
    return words, False


def odd_lines(errors: Array, typical: float) -> list[str]:
    """Errors (M, rows, columns, 2) [pixel] of views that are used → words where a line of corners is off."""
    spread = typical / 1.18  # the median length of a two-dimensional error is 1.18 standard deviations of one axis
    words = [""] * len(errors)
    for axis, word in ((1, "column"), (2, "row")):  # what is said of a row goes before
        means = np.linalg.norm(errors.mean(axis=axis), axis=2)
        worst = means.argmax(axis=1)
        most = means[np.arange(len(errors)), worst]
        for view in np.flatnonzero(most * np.sqrt(errors.shape[axis]) > ODD_ROW_SDS * max(spread, 0.01)).tolist():
            line = f"its {word} {worst[view] + 1} of corners is off by {most[view]:.2f} px as a whole"
            words[view] = f"used, but {line}"
    return words


def _orders(board: Board) -> list[tuple[Array, str]]:
    """Ways in which corners are listed in the wrong order, as index arrays that put them right."""
    grid = np.arange(board.count).reshape(board.rows, board.columns)
    turned = "its corners were counted from the wrong starting corner"
    found = [(np.roll(np.arange(board.count), shift), turned) for shift in (-1, 1)]
    for axis, words in ((0, "rows"), (1, "columns")):
        for shift in (-1, 1):
            found.append(
                (np.roll(grid, shift, axis=axis).ravel(), f"its corners are shifted by one square across the {words}")
            )
    for row in range(board.rows - 1):
        swapped = grid.copy()
        swapped[[row, row + 1]] = grid[[row + 1, row]]
        found.append((swapped.ravel(), f"its rows {row + 1} and {row + 2} of corners are swapped"))
    return found


def _error(pixels: Array, board: Board, camera: Array) -> float:
    """Corners (N, 2) → error [pixel] that 95 % of them keep after fitting the board's pose to them."""
    one = _one(board, pixels)
    pose = bundle_adjustment.refine_poses(
        one, BundleSolution(camera, homography.board_poses(one.points, one.pixels, camera)), soft=1.0
    )
    return float(
        np.quantile(np.linalg.norm(bundle_adjustment.errors(one, BundleSolution(camera, pose)), axis=2), 0.95)
    )


def _one(board: Board, pixels: Array) -> Corners:
    return Corners(board.points, pixels[None], np.ones((1, board.count), bool))
