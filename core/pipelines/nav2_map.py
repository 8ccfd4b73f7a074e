"""The occupancy map as Nav2's map server reads it: a YAML text and a PGM picture."""

from __future__ import annotations

import math

import numpy as np

from core.message import Array
from core.slam.map.occupancy import OccupancyGrid

OCCUPIED_PIXEL, FREE_PIXEL, UNKNOWN_PIXEL = 0, 254, 205

OCCUPIED_ABOVE = 0.65  # probability from which a cell is drawn occupied
FREE_BELOW = 0.35  # probability up to which a cell is drawn free: one passing beam alone does not clear it

# Nav2 turns pixels into (255 - pixel) / 255, so unknown is 0.19608: with the often copied 0.25 it would load as free.
THRESHOLDS = "occupied_thresh: 0.65\nfree_thresh: 0.196\n"


def map_pixels(grid: OccupancyGrid) -> Array:
    """Grid → picture (rows, columns) uint8, row 0 at the top, that is at the highest y."""
    pixels = np.full(grid.log_odds.shape, UNKNOWN_PIXEL, np.uint8)
    pixels[grid.log_odds >= _log_odds(OCCUPIED_ABOVE)] = OCCUPIED_PIXEL
    pixels[grid.log_odds <= _log_odds(FREE_BELOW)] = FREE_PIXEL
    return pixels[::-1]


def nav2_map(grid: OccupancyGrid, image: str = "map.pgm") -> tuple[str, bytes]:
    """Grid → (YAML text that names the picture `image`, the picture as binary PGM).

    Layout of Nav2's map_io: mode trinary, origin of the lower left corner as [x, y, yaw] in metres and radians.
    """
    x, y = (float(v) for v in grid.origin)
    text = (
        f"image: {image}\nmode: trinary\nresolution: {grid.resolution:.9f}\n"
        f"origin: [{x:.9f}, {y:.9f}, 0.0]\nnegate: 0\n{THRESHOLDS}"
    )
    pixels = map_pixels(grid)
    rows, columns = pixels.shape
    return text, f"P5\n{columns} {rows}\n255\n".encode() + pixels.tobytes()


def _log_odds(probability: float) -> float:
    return math.log(probability / (1 - probability))
