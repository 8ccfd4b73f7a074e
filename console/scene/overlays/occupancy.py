"""The occupancy map as a picture on the floor, unknown cells transparent; and the floor's grid."""

import itertools
import time

import cv2
import numpy as np
from viser import ImageHandle, SceneApi

from console.scene.drawing.palette import FREE, GRID, WALL
from core.message import Array
from core.robots import Profile
from core.slam.map.occupancy import OccupancyGrid
from core.slam.map.outline import trace_outline
from core.snapshot import Snapshot

MIN_PERIOD_S = 0.5  # between two pictures
CELL_PX, MAX_SIDE_PX = 3, 1800  # picture elements along a cell and along a side
WALL_OPACITY, FLOOR_OPACITY = 235, 46
SUBPIXEL_BITS = 4
MAP_HEIGHT_M = -0.004  # under the grid


class Occupancy:
    """A new picture when the map has changed, at most twice a second."""

    def __init__(self, scene: SceneApi, robot: Profile) -> None:
        self._scene = scene
        self._node: ImageHandle | None = None
        self._former: ImageHandle | None = None  # stays until the browser has unpacked what replaces it
        self._numbers = itertools.count(1)
        self._shown: OccupancyGrid | None = None
        self._drawn_at = -MIN_PERIOD_S
        self._placed: tuple[float, ...] = ()

    def show(self, snapshot: Snapshot) -> None:
        """Draw the grid, if it is new and it is time."""
        grid, now = snapshot.grid, time.monotonic()
        if grid is self._shown or grid.log_odds.size == 0 or now - self._drawn_at < MIN_PERIOD_S:
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
            position=(*placed[2:], MAP_HEIGHT_M),
            cast_shadow=False,
            receive_shadow=False,
        )


def paint(grid: OccupancyGrid) -> Array:
    """Grid → picture (H, W, 4) uint8 of its outline, row 0 at the highest y."""
    rows, columns = grid.log_odds.shape
    finer = max(1, min(CELL_PX, MAX_SIDE_PX // max(rows, columns)))
    outline, shape = trace_outline(grid), (rows * finer, columns * finer)
    scale, corner = finer / grid.resolution, grid.origin + np.array([0.0, rows * grid.resolution])
    wall, floor = (filled(rings, corner, scale, shape) for rings in (outline.walls, outline.floor))
    picture = np.empty((*shape, 4), np.uint8)
    picture[..., :3] = np.where(wall[..., None] > 0, np.array(WALL), np.array(FREE))
    picture[..., 3] = np.maximum(wall * WALL_OPACITY, floor * FLOOR_OPACITY).astype(np.uint8)
    return picture


def filled(rings: tuple[Array, ...], corner: Array, scale: float, shape: tuple[int, int]) -> Array:
    """Rings [m] → how much of each picture element (H, W) lies within, 0..1; `corner` [m] is the upper left one."""
    picture = np.zeros(shape, np.uint8)
    drawn = [((ring - corner) * (scale, -scale) - 0.5) * 2**SUBPIXEL_BITS for ring in rings]
    cv2.fillPoly(picture, [np.round(ring).astype(np.int32) for ring in drawn], 255, cv2.LINE_AA, SUBPIXEL_BITS)
    return picture.astype(np.float32) / 255


class GroundGrid:
    """Half-metre cells that fade into the distance."""

    def __init__(self, scene: SceneApi, robot: Profile) -> None:
        scene.add_grid(
            "/floor",
            width=60.0,
            height=60.0,
            cell_size=0.5,
            cell_color=GRID,
            cell_thickness=0.4,
            section_size=1.0,
            section_color=GRID,
            section_thickness=0.8,
            fade_distance=28.0,
            fade_strength=1.6,
            shadow_opacity=0.18,
            position=(0.0, 0.0, 0.001),
        )

    def show(self, snapshot: Snapshot) -> None:
        """Nothing to do."""
