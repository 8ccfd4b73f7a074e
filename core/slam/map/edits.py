"""Edits of the map by people, laid over what was seen: nothing that is seen later draws over them.

What was seen stays as it is underneath, and the robot finds its place by that alone: a chair that was erased and
still stands, or a pane of glass that was drawn, would mislead it. An edit that is taken back leaves no trace.
"""

import itertools
from dataclasses import dataclass
from typing import Literal

import cv2
import numpy as np

from core.message import Array
from core.slam.map.occupancy import OccupancyGrid, grown

CellEdit = Literal["free", "occupied", "unknown", "crop"]

SAID_LOG_ODDS = 6.0  # of a cell that people say is occupied: more than any that was only seen
EVIDENCE: dict[CellEdit, float] = {"free": -SAID_LOG_ODDS, "occupied": SAID_LOG_ODDS, "unknown": 0.0}


@dataclass(frozen=True, eq=False)
class MapEdit:
    """One edit, in the world as it is now."""

    kind: CellEdit  # crop: all outside of it is unknown
    points: Array  # (N, 2) [m], world: corners of an area, or the way of a brush
    width: float = 0.0  # [m] of the brush; 0: the area within the points

    def cells(self, grid: OccupancyGrid) -> Array:
        """Mask (rows, columns) of the cells that it changes: those whose middle lies in it."""
        corners = (self.points - grid.origin) / grid.resolution - 0.5
        reach = 0.5 * self.width / grid.resolution
        rows, columns = grid.log_odds.shape
        low = np.clip(np.floor(corners.min(axis=0) - reach).astype(int), 0, (columns, rows))
        high = np.clip(np.ceil(corners.max(axis=0) + reach).astype(int) + 1, low, (columns, rows))
        mask = np.zeros((rows, columns), bool)
        if (high > low).all():
            part = mask[low[1] : high[1], low[0] : high[0]]
            x, y = np.meshgrid(np.arange(part.shape[1]), np.arange(part.shape[0]))
            part[:] = _swept(corners - low, reach, part.shape) if self.width else within(corners - low, x, y)
        return ~mask if self.kind == "crop" else mask


@dataclass(frozen=True)
class MapEdits:
    """All edits that hold, in the order in which they were made."""

    edits: tuple[MapEdit, ...] = ()

    def on(self, grid: OccupancyGrid) -> OccupancyGrid:
        """The grid with these edits, grown to hold what was drawn; without any the very same grid."""
        if not self.edits:
            return grid
        drawn = [edit for edit in self.edits if edit.kind in ("free", "occupied")]
        if drawn:
            reach = 0.5 * max(edit.width for edit in drawn) + grid.resolution
            points = np.vstack([edit.points for edit in drawn])
            grid = grown(grid, points.min(axis=0) - reach, points.max(axis=0) + reach)
        log_odds = grid.log_odds.copy()
        for edit in self.edits:
            log_odds[edit.cells(grid)] = EVIDENCE.get(edit.kind, 0.0)
        return OccupancyGrid(
            revision=grid.revision, resolution=grid.resolution, origin=grid.origin, log_odds=log_odds
        )

    def hides(self, grid: OccupancyGrid, points: Array) -> Array:
        """Points (K, 2) [m], world → (K,) bool: those in cells that the last edit there made free or unknown."""
        rows, columns = grid.log_odds.shape
        hidden = np.zeros((rows, columns), bool)
        for edit in self.edits:
            hidden[edit.cells(grid)] = edit.kind != "occupied"
        column, row = np.floor((points.reshape(-1, 2) - grid.origin) / grid.resolution).astype(int).T
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        return inside & hidden[np.where(inside, row, 0), np.where(inside, column, 0)]


def within(corners: Array, x: Array, y: Array) -> Array:
    """Places x and y (...) → (...) bool: those in the polygon (N, 2), by the even-odd rule."""
    inside = np.zeros(x.shape, bool)
    for (x0, y0), (x1, y1) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        if y0 != y1:
            inside ^= ((y0 > y) != (y1 > y)) & (x < (x1 - x0) * (y - y0) / (y1 - y0) + x0)
    return inside


def _swept(corners: Array, reach: float, shape: tuple[int, ...]) -> Array:
    """Mask of the cells whose middle lies within `reach` cells of a way (N, 2) in cells."""
    fine = np.vstack([_spots(a, b) for a, b in itertools.pairwise(corners)] or [corners])
    mask = np.ones((shape[0] + 2, shape[1] + 2), np.uint8)
    spots = np.clip(np.rint(fine).astype(int) + 1, 0, (shape[1] + 1, shape[0] + 1))
    mask[spots[:, 1], spots[:, 0]] = 0
    return cv2.distanceTransform(mask, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1] <= max(reach, 0.5)


def _spots(a: Array, b: Array) -> Array:
    """Points (K, 2) from a to b, half a cell apart."""
    return a + np.linspace(0.0, 1.0, 2 + int(2 * np.abs(b - a).max()))[:, None] * (b - a)
