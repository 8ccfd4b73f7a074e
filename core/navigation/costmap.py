"""The occupancy map as the planner sees it: how far every place is from the nearest wall."""

import math

import cv2
import numpy as np

from core.message import Array, message
from core.slam.map.occupancy import OccupancyGrid


@message
class Costmap:
    """A window of the world on the map's own lattice. Row 0 lies at the lowest y."""

    resolution: float  # [m]
    origin: Array  # (2,) [m], world: the centre of cell [0, 0]
    clearance: Array  # (rows, columns) float32 [m] from the cell's centre to the nearest wall
    known: Array  # (rows, columns) bool: seen free or occupied

    def cells(self, points: Array) -> tuple[Array, Array]:
        """Points (N, 2) [m], world → rows (N,) and columns (N,) of their cells, clipped to the window."""
        rows, columns = self.clearance.shape
        row = np.rint((points[:, 1] - self.origin[1]) / self.resolution).astype(int)
        column = np.rint((points[:, 0] - self.origin[0]) / self.resolution).astype(int)
        return np.clip(row, 0, rows - 1), np.clip(column, 0, columns - 1)

    def places(self, rows: Array, columns: Array) -> Array:
        """Rows (N,) and columns (N,) → the centres (N, 2) [m], world."""
        return np.column_stack((columns, rows)) * self.resolution + self.origin

    def clearance_at(self, points: Array) -> Array:
        """Points (N, 2) [m], world → distance (N,) [m] to the nearest wall."""
        return self.clearance[self.cells(points)]

    def known_at(self, x: float, y: float) -> bool:
        """Return whether the place (x, y) [m], world, has been seen."""
        row, column = self.cells(np.array([[x, y]]))
        return bool(self.known[row[0], column[0]])


def survey(grid: OccupancyGrid, seen: Array, low: Array, high: Array, occupied: float) -> Costmap:
    """The map, and the newest scan's points on top of it, as a terrain between two corners.

    `seen` (M, 2) [m], world; `low`, `high` (2,) [m], world: the window, which may reach beyond the map (unknown
    there); `occupied`: log-odds from which a cell counts as wall.
    """
    step = grid.resolution
    first = np.floor((low - grid.origin) / step).astype(int)[::-1]
    last = np.ceil((high - grid.origin) / step).astype(int)[::-1]
    log_odds = np.zeros(last - first, np.float32)
    start, end = np.maximum(first, 0), np.minimum(last, grid.log_odds.shape)
    if (end > start).all():
        log_odds[tuple(map(slice, start - first, end - first))] = grid.log_odds[tuple(map(slice, start, end))]
    origin = grid.origin + (first[::-1] + 0.5) * step
    wall = log_odds > occupied
    inside = seen[((seen >= low) & (seen < high)).all(axis=1)]
    if len(inside):
        column, row = np.rint((inside - origin) / step).astype(int).T
        wall[row.clip(0, wall.shape[0] - 1), column.clip(0, wall.shape[1] - 1)] = True
    clearance = np.full(wall.shape, math.inf, np.float32)
    if wall.any():
        clearance = cv2.distanceTransform((~wall).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * np.float32(
            step
        )
    return Costmap(resolution=step, origin=origin, clearance=clearance, known=(log_odds != 0) | wall)
