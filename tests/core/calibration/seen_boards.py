"""Boards as the paper's camera sees them, for the tests."""

import numpy as np

from core.calibration.board.board import Board
from core.calibration.camera.bundle_adjustment import BundleSolution, Corners
from core.calibration.camera.intrinsics import ViewCorners
from core.calibration.practice import BoardPlacement, held, seen
from core.calibration.projection import Poses, vector_of
from core.message import Array
from core.optics import TABLE_3

BOARD = Board(columns=9, rows=6, square=0.03)
SIZE = (TABLE_3.width, TABLE_3.height)


def some_poses(count: int, seed: int = 0, how: BoardPlacement | None = None) -> Poses:
    return held(np.random.default_rng(seed), count, TABLE_3, BOARD, how)


def some_corners(
    count: int, noise: float, seed: int = 0, how: BoardPlacement | None = None
) -> tuple[Corners, BundleSolution]:
    rng = np.random.default_rng(seed)
    poses = held(rng, count, TABLE_3, BOARD, how)
    pixels = seen(rng, TABLE_3, poses, BOARD, noise)
    truth = BundleSolution(vector_of(TABLE_3), poses)
    return Corners(BOARD.points, pixels, np.ones(pixels.shape[:2], bool)), truth


def views_of(pixels: Array) -> list[ViewCorners]:
    return [ViewCorners(name=f"view {number}", corners=corners) for number, corners in enumerate(pixels)]
