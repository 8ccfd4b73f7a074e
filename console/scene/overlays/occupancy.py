"""The occupancy map as a picture on the floor; unknown cells stay transparent."""

from __future__ import annotations

import itertools
import time

import cv2
import numpy as np
from viser import ImageHandle, SceneApi

from console.scene.drawing.palette import FREE, WALL
from core.message import Array
from core.robots import Profile
from core.slam.map.occupancy import OccupancyGrid
from core.snapshot import Snapshot

PERIOD = 0.5  # [s] at least between two pictures
FINER = 3  # picture elements along a cell: walls get smooth edges
LARGEST = 1800  # picture elements along a side
LOW = -0.004  # [m], under the grid


class Occupancy:
    """A new picture when the map has changed, at most twice a second."""

    def __init__(self, scene: SceneApi, robot: Profile) -> None:
        self._scene = scene
        self._node: ImageHandle | None = None
        self._former: ImageHandle | None = None  # stays until the browser has unpacked what replaces it
        self._numbers = itertools.count(1)
        self._shown: OccupancyGrid | None = None
        self._drawn_at = -PERIOD
        self._placed: tuple[float, ...] = ()

    def show(self, snapshot: Snapshot) -> None:
        """Draw the grid, if it is new and it is time."""
        grid, now = snapshot.grid, time.monotonic()
        if grid is self._shown or grid.log_odds.size == 0 or now - self._drawn_at < PERIOD:
            return
        self._shown, self._drawn_at = grid, now
        picture = paint(grid)
        if self._former is not None:
            self._former.remove()
            self._former = None
        rows, columns = grid.log_odds.shape
        width, height = columns * grid.resolution, rows * grid.resolution
        placed = (width, height, float(grid.origin[0]) + width / 2, float(grid.origin[1]) + height / 2)
        if self._node is not None and placed == self._placed:
            self._node.image = picture
            return
        self._former, self._placed = self._node, placed
        self._node = self._scene.add_image(
            f"/map/{next(self._numbers)}",
            picture,
            render_width=width,
            render_height=height,
            format="png",
            wxyz=(0.0, 1.0, 0.0, 0.0),
            position=(*placed[2:], LOW),
            cast_shadow=False,
            receive_shadow=False,
        )


def paint(grid: OccupancyGrid) -> Array:
    """Grid → picture (H, W, 4) uint8, row 0 at the highest y."""
    rows, columns = grid.log_odds.shape
    finer = max(1, min(FINER, LARGEST // max(rows, columns)))
    odds = np.clip(grid.log_odds[::-1], -2.0, 2.0).astype(np.float32)
    if finer > 1:
        odds = cv2.resize(odds, (columns * finer, rows * finer), interpolation=cv2.INTER_CUBIC)
    wall = np.clip(odds / 1.2, 0.0, 1.0)
    wall = wall * wall * (3 - 2 * wall)
    free = np.clip(-odds / 1.2, 0.0, 1.0)
    picture = np.empty((*odds.shape, 4), np.uint8)
    picture[..., :3] = np.where(wall[..., None] > 0, np.array(WALL), np.array(FREE))
    picture[..., 3] = np.maximum(235 * wall, 46 * free).astype(np.uint8)
    return picture
