"""The world's occupancy map, composed of the submaps' tiles wherever the graph has put them."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

import cv2
import numpy as np

from core.geometry import Pose
from core.message import Array
from core.slam.map.map_graph import MapGraph
from core.slam.map.occupancy import OccupancyGrid, OccupancySettings
from core.slam.map.submap import Submap

MAP_PERIOD_S = 0.5  # between two maps, at least, once there are several tiles
FREE_BOUND_SHARE = 0.375  # of the bound, to which one tile may claim free space: no two wipe out a third one's wall
AT_HOME = 1e-9  # [m], [rad]: a tile that lies so is taken as it is


class GlobalGrid:
    """Nothing is baked in: tiles move with their submaps."""

    def __init__(self, graph: MapGraph, settings: OccupancySettings) -> None:
        self._graph, self._settings = graph, settings
        self._still: _Canvas | None = None  # all tiles but the active one
        self._still_key: tuple[int, int, int] | None = None
        self._labour: Generator[None, None, None] | None = None
        self._grid: OccupancyGrid | None = None
        self._key: tuple[tuple[int, int, int] | None, int, int] | None = None
        self._tiles: dict[int, tuple[int, _Tile]] = {}  # submap → revision of its tile, and what it knew then
        self._stamp = -np.inf
        self._revision = 0

    def grid(self, active: Submap, stamp: float) -> OccupancyGrid:
        """Return the map now, or the last one as long as it is fresh."""
        if len(self._graph.submaps) == 1 and self._at_home():
            tile = active.tile.grid()
            self._revision = tile.revision
            return tile
        key = self._still_key, active.id, active.tile.revision
        if self._grid is not None and (key == self._key or 0 <= stamp - self._stamp < MAP_PERIOD_S):
            return self._grid
        placed = self._graph.world_from(active.id), self._known(active)
        canvas = _Canvas.around([placed], self._still, self._settings)
        canvas.add(*placed)
        self._key, self._stamp = key, stamp
        self._revision += 1
        self._grid = canvas.grid(self._revision)
        return self._grid

    def rest(self, submap: Submap) -> None:
        """The robot leaves this submap: its tile rests with the others."""
        placed = self._graph.world_from(submap.id), self._known(submap)
        self._still = _Canvas.around([placed], self._still, self._settings)
        self._still.add(*placed)

    def work(self, active: int, pieces: int) -> None:
        """Redraw the resting tiles where they have moved, one with every piece."""
        key = (self._graph.revision, len(self._graph.submaps), active)
        if self._labour is None and key != self._still_key and len(self._graph.submaps) > 1:
            self._labour = self._lay(active, key)
        for _ in range(pieces if self._labour is not None else 0):
            if self._labour is not None and next(self._labour, "over") == "over":
                self._labour = None

    def finish(self, active: int) -> None:
        """Redraw everything at once."""
        self._labour, self._still_key, self._stamp = None, None, -np.inf
        while self._labour is not None or (self._still_key is None and len(self._graph.submaps) > 1):
            self.work(active, 100)

    def _lay(self, active: int, key: tuple[int, int, int]) -> Generator[None, None, None]:
        resting = [submap for submap in self._graph.submaps if submap.id != active and submap.views]
        placed = [(self._graph.world_from(submap.id), self._known(submap)) for submap in resting]
        yield
        canvas = _Canvas.around(placed, None, self._settings)
        for pose, tile in placed:
            canvas.add(pose, tile)
            yield
        self._still, self._still_key = canvas, key

    def _known(self, submap: Submap) -> _Tile:
        """Return a submap's tile without the unknown around it."""
        revision, kept = self._tiles.get(submap.id, (-1, _Tile(np.zeros(2), np.zeros((0, 0), np.float32))))
        if revision == submap.tile.revision:
            return kept
        origin, values = submap.tile.cells
        rows, columns = (np.flatnonzero((values != 0).any(axis=axis)) for axis in (1, 0))
        if len(rows) and len(columns):
            part = values[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1].copy()
            kept = _Tile(origin + self._settings.resolution * np.array([columns[0], rows[0]]), part)
        self._tiles[submap.id] = submap.tile.revision, kept
        return kept

    def _at_home(self) -> bool:
        if not self._graph.views:
            return True
        pose = self._graph.world_from(0)
        return max(abs(pose.x), abs(pose.y), abs(pose.heading)) < AT_HOME


@dataclass(frozen=True, eq=False)
class _Tile:
    """The known part of a submap: log odds (rows, columns), and the outer corner of the first cell."""

    origin: Array  # (2,) [m], submap frame
    values: Array

    def corners(self, cell: float) -> Array:
        """The four corners (4, 2) [m], in the submap's frame."""
        height, width = (side * cell for side in self.values.shape)
        return self.origin + np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])


class _Canvas:
    """Log odds on a grid in the world, large enough for what comes on it."""

    def __init__(self, origin: Array, values: Array, settings: OccupancySettings) -> None:
        self.origin, self.values, self._settings = origin, values, settings

    @staticmethod
    def around(placed: list[tuple[Pose, _Tile]], start: _Canvas | None, settings: OccupancySettings) -> _Canvas:
        """Make a canvas around tiles at their poses, with the content of another one."""
        cell, block = settings.resolution, round(settings.block / settings.resolution)
        corners = [pose.apply(tile.corners(cell)) for pose, tile in placed if tile.values.size]
        if start is not None:
            corners.append(start.origin + np.array([[0, 0], start.values.shape[::-1]]) * cell)
        points = np.vstack(corners) if corners else np.zeros((1, 2))
        points = np.clip(points, -settings.widest, settings.widest)
        low = np.floor(points.min(axis=0) / (cell * block) + 1e-9).astype(int) * block
        high = np.ceil(points.max(axis=0) / (cell * block) - 1e-9).astype(int) * block
        values = np.zeros((max(high[1] - low[1], block), max(high[0] - low[0], block)), np.float32)
        if start is not None:
            column, row = np.round(start.origin / cell).astype(int) - low
            values[row : row + start.values.shape[0], column : column + start.values.shape[1]] = start.values
        return _Canvas(low * cell, values, settings)

    def add(self, pose: Pose, tile: _Tile) -> None:
        """Add a tile: the log odds of both add up."""
        if not tile.values.size:
            return
        cell = self._settings.resolution
        corners = (pose.apply(tile.corners(cell)) - self.origin) / cell
        low = np.clip(np.floor(corners.min(axis=0)).astype(int), 0, np.array(self.values.shape[::-1]) - 1)
        high = np.clip(np.ceil(corners.max(axis=0)).astype(int) + 1, low + 1, self.values.shape[::-1])
        back = pose.inverse()
        first = (back.apply((self.origin + (low + 0.5) * cell)[None])[0] - tile.origin) / cell - 0.5
        c, s = np.cos(back.heading), np.sin(back.heading)
        onto = np.array([[c, -s, first[0]], [s, c, first[1]]])
        size = (int(high[0] - low[0]), int(high[1] - low[1]))
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        laid = cv2.warpAffine(tile.values, onto, size, flags=flags, borderValue=0.0)
        laid = np.maximum(laid, -self._settings.bound * FREE_BOUND_SHARE)
        part = self.values[low[1] : high[1], low[0] : high[0]]
        np.clip(part + laid, -self._settings.bound, self._settings.bound, out=part)

    def grid(self, revision: int) -> OccupancyGrid:
        """The canvas as a message."""
        self.values.setflags(write=False)
        return OccupancyGrid(
            revision=revision, resolution=self._settings.resolution, origin=self.origin, log_odds=self.values
        )
