"""View of an upright plane some way ahead, brought to the scale of the model."""

import math

import cv2
import numpy as np

from core.message import Array
from core.perception.people.parts import CEILING_M, CELL_PX, CELLS_PER_METRE, PIXELS_PER_METRE, VIEW_ROWS
from core.sensors import Camera

COARSE_STEP_PX = 8  # between the places that are projected exactly; between them it is linear
PYRAMID_LEVELS = 4  # of halving, for people who are near


class VerticalPlanes:
    """Cuts planes out of one picture."""

    def __init__(self, pixels: Array, camera: Camera) -> None:
        """Pixels (H, W, 3) uint8."""
        self.camera = camera
        self._images = [pixels]
        self._widest = camera.model.widest_ray
        self._to_camera = camera.mounting.inverse()

    def cut(self, distance: float, bearing: float, half: float) -> tuple[Array, Array]:
        """Plane `distance` [m] from the camera towards `bearing` [rad, robot frame], `half` [m] to both sides.

        → pixels (ROWS·CELL, C·CELL, 3) at SCALE, from CEILING down, and which cells (ROWS, C) are in the picture.
        """
        width, height = columns_of(half) * CELL_PX, VIEW_ROWS * CELL_PX
        u, v = self._where(distance, bearing, width, height)
        shrunk = self.camera.model.fx / (distance * PIXELS_PER_METRE)
        level = min(PYRAMID_LEVELS - 1, max(0, round(math.log2(max(shrunk, 1.0)))))
        image, factor = self._level(level), 0.5**level
        pixels = cv2.remap(image, u * factor, v * factor, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        model = self.camera.model
        inside = (u > -0.5) & (u < model.width - 0.5) & (v > -0.5) & (v < model.height - 0.5)
        return pixels, np.asarray(inside.reshape(VIEW_ROWS, CELL_PX, -1, CELL_PX).all(axis=(1, 3)))

    def pixels_of(self, distance: float, bearing: float, places: Array) -> Array:
        """Places (K, 2) [m] on that plane, to the left and above the floor → pixels (K, 2); NaN out of the lens."""
        c, s = math.cos(bearing), math.sin(bearing)
        eye = self.camera.mounting.translation
        left, up = places[:, 0], places[:, 1]
        points = np.column_stack((eye[0] + distance * c - left * s, eye[1] + distance * s + left * c, up))
        seen = self._to_camera.apply(points)
        ahead = seen[:, 2] > 0.05
        off = np.hypot(seen[:, 0], seen[:, 1]) / np.where(ahead, seen[:, 2], np.nan)
        found = np.full((len(seen), 2), np.nan)
        fits = ahead & (off <= 1.25 * self._widest)  # beyond, the distortion folds back
        found[fits] = self.camera.model.project(seen[fits])
        return found

    def _where(self, distance: float, bearing: float, width: int, height: int) -> tuple[Array, Array]:
        """Columns and rows of the picture (H, W) float32 that the plane's pixels look at; far outside: -1e4."""
        across = np.arange(0, width + COARSE_STEP_PX, COARSE_STEP_PX)
        down = np.arange(0, height + COARSE_STEP_PX, COARSE_STEP_PX)
        left = (width / 2 - across - 0.5) / PIXELS_PER_METRE
        up = CEILING_M - (down + 0.5) / PIXELS_PER_METRE
        places = np.stack(np.meshgrid(left, up), axis=-1).reshape(-1, 2)
        found = np.nan_to_num(self.pixels_of(distance, bearing, places), nan=-1e4).astype(np.float32)
        grid = found.reshape(len(down), len(across), 2)
        share_u, share_v = (
            np.arange(width, dtype=np.float32) / COARSE_STEP_PX,
            np.arange(height, dtype=np.float32) / COARSE_STEP_PX,
        )
        map_x, map_y = np.meshgrid(share_u, share_v)
        whole = cv2.remap(grid, map_x, map_y, cv2.INTER_LINEAR)
        return np.ascontiguousarray(whole[:, :, 0]), np.ascontiguousarray(whole[:, :, 1])

    def _level(self, level: int) -> Array:
        while len(self._images) <= level:
            self._images.append(cv2.pyrDown(self._images[-1]))
        return self._images[level]


def columns_of(half: float) -> int:
    """Cells of a view that reaches `half` [m] to either side, an even number."""
    return 2 * max(1, math.ceil(half * CELLS_PER_METRE))
