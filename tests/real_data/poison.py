"""Ways in which the corners of one picture of a 9x6 board go wrong; every one takes and gives corners (54, 2)."""

from collections.abc import Callable

import cv2
import numpy as np

from core.message import Array

GRID = (6, 9, 2)


def rolled(corners: Array) -> Array:
    return np.roll(corners.reshape(GRID), 1, axis=1).reshape(-1, 2)


def rolled_by_one_corner(corners: Array) -> Array:
    return np.roll(corners, 1, axis=0)


def shifted_and_continued(corners: Array) -> Array:
    """Every corner moved on by one square, the last row guessed from the two before."""
    grid = corners.reshape(GRID)
    return np.concatenate((grid[1:], 2 * grid[-1:] - grid[-2:-1])).reshape(-1, 2)


def misclicked(corners: Array) -> Array:
    """One clicked extreme corner 10 px off, and the grid warped with it."""
    extremes = corners[[0, 8, 45, 53]].astype(np.float32)
    moved = extremes.copy()
    moved[1] += (7, 7)
    warp = cv2.getPerspectiveTransform(extremes, moved)
    return cv2.perspectiveTransform(corners[None].astype(np.float32), warp)[0].astype(float)


def noisy(corners: Array) -> Array:
    return corners + np.random.default_rng(1).normal(0, 3, corners.shape)


def swapped(corners: Array) -> Array:
    grid = corners.reshape(GRID).copy()
    grid[[1, 2]] = grid[[2, 1]]
    return grid.reshape(-1, 2)


FAULTS: tuple[Callable[[Array], Array], ...] = (
    rolled,
    rolled_by_one_corner,
    shifted_and_continued,
    misclicked,
    noisy,
    swapped,
)
