"""Suspect views: why one does not fit, for the person who took it, and what the camera owes to each of them.

A set of views can hang on one of them: the only one that is tilted decides the focal length, rightly or not. Where it
is left out because it disagrees with the others, the others may be wrong. So both are reported in numbers: the camera
with a view that is left out, and without one that is used.
"""

from __future__ import annotations

import numpy as np

from core.calibration import homography
from core.calibration.board.board import Board
from core.calibration.camera import bundle_adjustment
from core.calibration.camera.bundle_adjustment import BundleSolution, Corners, NormalEquations
from core.message import Array, message

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


PINHOLE_NAMES = ("f", "fx", "fy", "cx", "cy")
MEANS = np.array([[0.5, 0.5, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
"""PINHOLE_NAMES from fx, fy, cx, cy; f is what both axes have in common."""
MIN_VIEWS = 6  # views used, with which the stated standard deviations mean something
SMALL_CHANGE_SDS = 1.0  # standard deviations that are no change
DECISIVE_SDS = 3.0  # standard deviations by which one view may not move the answer, nor narrow them
MIN_SD_PX = 1e-9  # no figure is better known
MOST_WORK = 400  # views that are solved again in all
ADVICE = "show more tilted views to decide"


@message
class Figures:
    """The figures of a camera that people know."""

    values: Array  # (..., 5) [pixel] of PINHOLE_NAMES
    sds: Array  # (..., 5) [pixel]

    def of(self, which: int) -> Figures:
        """Those of one of several cameras."""
        return Figures(values=self.values[which], sds=self.sds[which])

    def with_sd(self, number: int) -> str:
        """One of them with its standard deviation."""
        return f"{self.values[number]:.1f} ± {self.sds[number]:.1f}"


def figures(camera: Array, covariance: Array) -> Figures:
    """Camera (..., 9) and covariance (..., P, P) of its free parameters, which begin with fx, fy, cx and cy."""
    spread = np.sum(MEANS @ covariance[..., :4, :4] * MEANS, axis=-1)
    return Figures(values=camera[..., :4] @ MEANS.T, sds=np.sqrt(np.abs(spread)))


def with_each(corners: Corners, solution: BundleSolution, free: tuple[int, ...]) -> dict[int, Array]:
    """Views of which no corner is used → by number, the PINHOLE_NAMES' values (5,) [pixel] with that one too.

    Where there are many views, only the first that are left out are tried.
    """
    used = corners.views_used
    found: dict[int, Array] = {}
    for number in np.flatnonzero(~used)[: max(MOST_WORK // len(used), 1)]:
        one = np.arange(len(used)) == number
        some = Corners(corners.points, corners.pixels, corners.used | one[:, None]).take(used | one)
        refined = bundle_adjustment.refine(
            some, BundleSolution(solution.camera, solution.poses.take(used | one)), free
        )
        found[int(number)] = MEANS @ refined.camera[:4]
    return found


def without_each(
    corners: Corners, solution: BundleSolution, known: NormalEquations, free: tuple[int, ...], noise: float
) -> tuple[Array, Figures]:
    """Numbers (K,) of the used views, and the figures (K, 5) that the others give without each, to first order.

    At the best solution the pulls of all views cancel out; without one the others give way to what it held. `known`:
    the equations at this solution.
    """
    used = np.flatnonzero(corners.views_used)
    precision, pull = known.of(free)
    doubts = bundle_adjustment.covariance(precision.sum(axis=0) - precision[used], 1.0)
    cameras = np.tile(solution.camera, (len(used), 1))
    cameras[:, list(free)] += (doubts @ pull[used, :, None])[..., 0]
    return used, figures(cameras, noise**2 * doubts)


def words_with(values: Array, known: Figures, *, advise: bool) -> str:
    """The change that a left-out view would make, to follow the reason; `advise`: it is unknown which is right."""
    sds = np.abs(values - known.values) / np.maximum(known.sds, MIN_SD_PX)
    most = _foremost(sds)
    if sds[most] < SMALL_CHANGE_SDS:
        return f"with it nothing would change: f stays {known.values[0]:.1f} px"
    words = f"with it {PINHOLE_NAMES[most]} would be {values[most]:.1f} instead of {known.values[most]:.1f} px"
    words = f"{words}, {sds[most]:.0f} sd"
    return f"{words}: {ADVICE}" if advise and sds[most] > DECISIVE_SDS else words


def sway(others: Figures, known: Figures) -> Array:
    """(..., 5): how much a view decides, by what the `others` give: standard deviations that it moves, or narrows."""
    return np.maximum(np.abs(others.values - known.values), others.sds) / np.maximum(known.sds, MIN_SD_PX)


def words_without(others: Figures, known: Figures) -> str:
    """The figure that a used view decides by itself; "" for none."""
    swayed = sway(others, known)
    most = _foremost(swayed)
    if swayed[most] <= DECISIVE_SDS:
        return ""
    name = PINHOLE_NAMES[most]
    return (
        f"decides {name} by itself: without it {name} would be {others.with_sd(most)} px instead of "
        f"{known.with_sd(most)}; {ADVICE}"
    )


def _foremost(sds: Array) -> int:
    """The figure to report, by standard deviations (5,): f, where it moves nearly as much as any."""
    return 0 if sds[0] >= sds.max() / 2 else int(np.argmax(sds))
