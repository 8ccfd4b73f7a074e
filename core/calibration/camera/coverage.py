"""Coverage of the picture by the views: cells, and the four measures operators know from ROS's calibrator."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from core.calibration.board.board import Board
from core.message import Array

GRID_CELLS = (8, 6)  # across, down
WANTED_RANGES = (0.7, 0.7, 0.4, 0.5)  # that each measure should span


class Measures(NamedTuple):
    """Position, size and skew of a board in the picture, each 0..1."""

    x: float  # place across the picture
    y: float  # place down the picture
    size: float  # root of the share of the picture that it fills
    skew: float  # how far its corner is from a right angle


def measures(corners: Array, board: Board, size: tuple[int, int]) -> Measures:
    """Corners (N, 2) [pixel] in a picture of this width and height → its four measures."""
    grid = corners.reshape(board.rows, board.columns, 2)
    up_left, up_right, down_right, down_left = grid[0, 0], grid[0, -1], grid[-1, -1], grid[-1, 0]
    one, other = down_right - up_left, down_left - up_right
    area = abs(float(one[0] * other[1] - one[1] * other[0])) / 2
    border = np.sqrt(area)
    place = (corners.mean(axis=0) - border / 2) / np.maximum(np.array(size) - border, 1.0)
    along, down = up_left - up_right, down_right - up_right
    cosine = float(along @ down / (np.linalg.norm(along) * np.linalg.norm(down)))
    skew = min(1.0, 2 * abs(np.pi / 2 - float(np.arccos(np.clip(cosine, -1, 1)))))
    x, y = np.clip(place, 0, 1)
    return Measures(float(x), float(y), float(border / np.sqrt(size[0] * size[1])), skew)


def bars(seen: list[Measures]) -> Measures:
    """The measures of all views → how far each has been spanned, 0..1; size and skew count from zero."""
    if not seen:
        return Measures(0.0, 0.0, 0.0, 0.0)
    values = np.array(seen)
    low = values.min(axis=0) * (1, 1, 0, 0)
    return Measures(*(float(value) for value in np.minimum(1.0, (values.max(axis=0) - low) / WANTED_RANGES)))


def cells(corners: list[Array], size: tuple[int, int]) -> Array:
    """Corners (N, 2) [pixel] of every view → how many fell into each cell of the picture (6, 8)."""
    pixels = np.concatenate(corners) if corners else np.empty((0, 2))
    edges = (np.linspace(0, size[1], GRID_CELLS[1] + 1), np.linspace(0, size[0], GRID_CELLS[0] + 1))
    return np.histogram2d(pixels[:, 1], pixels[:, 0], bins=edges)[0].astype(int)
