"""The map prepared for finding a place on it: likelihood field, free floor and bounds."""

from __future__ import annotations

import math
from collections.abc import Generator

import cv2
import numpy as np

from core.geometry import Pose
from core.message import Array, message
from core.perception.landmarks.frame_perception import Beams
from core.slam.map.occupancy import OccupancyGrid
from core.slam.scan_matching.likelihood_field import CELL_M, LikelihoodField

OCCUPIED_LOG_ODDS = 0.6  # log odds from which a cell holds something
FREE = -0.3  # log odds up to which it is known to hold nothing
CELLS_PER_POOL = 6  # cells of the likelihood field to a coarse one
POOL_M = CELLS_PER_POOL * CELL_M  # of a coarse cell
NEAR_WALL_M = 0.2  # around a wall where a point still belongs to it
BEAM_SLACK_M = 0.08  # to either side of a beam that may graze a wall
MAX_REACH_M = 12.0  # beyond which points are not searched with: they ask for finer headings
GRAIN_M = 0.1  # of squares of which one end of a beam each is kept
FEWEST_CELLS = 40  # occupied ones; with fewer there is nothing to be found again


@message
class ScanView:
    """The laser's view at one instant, in the robot frame of that instant."""

    stamp: float  # [s]
    odometry: Pose  # where wheels or scans believe to be, in a frame of their own that is smooth
    start: Array  # (2,) [m]: where the beams begin
    points: Array  # (K, 2) [m]: where they ended on something
    misses: Array  # (M, 2) [m]: ends of those that met nothing

    @staticmethod
    def of_beams(stamp: float, odometry: Pose, beams: Beams) -> ScanView:
        """A scan's beams → the view.

        Of the ends in each square of GRAIN_M one is kept: so that near walls count no more than far ones.
        """
        ends, hits, mounting = beams.ends, beams.hits, beams.viewpoint
        known = np.isfinite(ends).all(axis=1)
        return ScanView(
            stamp=stamp,
            odometry=odometry,
            start=np.array([mounting.x, mounting.y]),
            points=thinned(ends[known & hits], GRAIN_M),
            misses=thinned(ends[known & ~hits], 3 * GRAIN_M),
        )


class SearchPyramid:
    """A map as a likelihood field, as a coarse spectrum, and as what is known to be free.

    Make it with `prepare`, which works in small pieces. It does not change: a later map needs another one.
    """

    def __init__(self, grid: OccupancyGrid, field: LikelihoodField, gap: Array) -> None:
        self.grid, self.field = grid, field
        self.gap = gap  # (rows, columns) [m] to the next wall
        self.occupied = grid.log_odds > OCCUPIED_LOG_ODDS
        self.free = grid.log_odds < FREE
        self.bound = _bound(field.values)
        self.standable = self._standable()
        self._spectra: dict[tuple[int, int], Array] = {}

    @staticmethod
    def prepare(grid: OccupancyGrid, points: Array | None = None) -> Generator[None, None, SearchPyramid | None]:
        """The map's grid and the points (K, 2) [m], world, that its walls are made of (none: the occupied cells).

        Yields between pieces of work; returns None for a map too empty to find anything on.
        """
        cells = np.argwhere(grid.log_odds > OCCUPIED_LOG_ODDS)
        if len(cells) < FEWEST_CELLS:
            return None
        yield
        field = LikelihoodField(grid.origin + (cells[:, ::-1] + 0.5) * grid.resolution if points is None else points)
        yield
        gap = cv2.distanceTransform((grid.log_odds <= OCCUPIED_LOG_ODDS).astype(np.uint8), cv2.DIST_L2, 3)
        gap *= np.float32(grid.resolution)
        yield
        pyramid = SearchPyramid(grid, field, gap)
        yield
        return pyramid

    def spectrum(self, size: tuple[int, int]) -> Array:
        """The coarse bound's transform, padded to `size` (rows, columns); kept."""
        if size not in self._spectra:
            padded = np.zeros(size, np.float32)
            padded[: self.bound.shape[0], : self.bound.shape[1]] = self.bound
            self._spectra[size] = cv2.dft(padded)
        return self._spectra[size]

    def standing(self, x: float, y: float) -> bool:
        """Return whether the map has free floor at (x, y) [m] or next to it."""
        (column, row), (rows, columns) = self._cells(np.array([x, y])), self.free.shape
        if not (0 <= row < rows and 0 <= column < columns):
            return False
        return bool(self.free[max(0, row - 1) : row + 2, max(0, column - 1) : column + 2].any())

    def known(self, points: Array) -> Array:
        """Points (K, 2) [m], world → (K,) int: 1 at a wall, -1 in the middle of free floor, 0 anything else."""
        row, column, inside = self._indices(points)
        return np.where(inside, np.where(self.gap[row, column] < NEAR_WALL_M, 1, -1 * self.free[row, column]), 0)

    def crossed(self, start: Array, ends: Array) -> Array:
        """Beams from `start` (2,) to `ends` (K, 2) [m], world → (K,) bool: those that went through a wall.

        Through means: a cell of a wall, and behind it a place that is well away from any wall, still before the end;
        and the same for the beams a little to either side: a beam may graze a corner.
        """
        way = ends - start
        length = np.hypot(way[:, 0], way[:, 1])
        ray = way / np.maximum(length, 1e-9)[:, None]
        found = self._through(start, ray, length)
        aside = BEAM_SLACK_M * ray[:, ::-1] * (-1.0, 1.0)
        for side in (aside, -aside):
            found[found] = self._through(start + side[found], ray[found], length[found])
        return found

    def _through(self, starts: Array, rays: Array, lengths: Array) -> Array:
        """Beams from (2,) or (K, 2) [m], world, along unit vectors (K, 2) → (K,) bool: those that cross a wall."""
        count = max(2, math.ceil(min(float(lengths.max(initial=0.0)), MAX_REACH_M) / self.grid.resolution))
        along = self.grid.resolution * np.arange(1, count)
        row, column, inside = self._indices(starts[..., None, :] + along[:, None] * rays[:, None, :])
        before = (along[None, :] < (lengths - NEAR_WALL_M)[:, None]) & inside
        behind = np.maximum.accumulate(self.occupied[row, column] & before, axis=1)
        through = behind & before & (self.gap[row, column] > 0.75 * NEAR_WALL_M)
        return np.logical_or.reduce(through, axis=1)

    def _cells(self, points: Array) -> Array:
        return np.floor((points - self.grid.origin) / self.grid.resolution).astype(int)

    def _indices(self, points: Array) -> tuple[Array, Array, Array]:
        """Points (..., 2) [m], world → rows and columns of the grid (...) and whether they lie in it (...)."""
        cells = self._cells(points)
        inside = np.logical_and.reduce((cells >= 0) & (cells < self.free.shape[::-1]), axis=-1)
        return np.where(inside, cells[..., 1], 0), np.where(inside, cells[..., 0], 0), inside

    def _standable(self) -> Array:
        """Return where a robot may stand: (rows, columns) bool, of the shape of `bound`."""
        rows, columns = self.bound.shape
        free = self.grid.origin + (np.argwhere(self.free[::2, ::2])[:, ::-1] * 2 + 0.5) * self.grid.resolution
        coarse = np.floor((free - self.field.origin) / POOL_M).astype(int)
        coarse = coarse[((coarse >= 0) & (coarse < (columns, rows))).all(axis=1)]
        standable = np.zeros((rows, columns), bool)
        standable[coarse[:, 1], coarse[:, 0]] = True
        return standable


def _bound(values: Array) -> Array:
    """A field → its coarse upper bound (rows, columns), which holds for any shift within one coarse cell."""
    rows, columns = (-(-side // CELLS_PER_POOL) for side in values.shape)
    grown = np.zeros(((rows + 1) * CELLS_PER_POOL, (columns + 1) * CELLS_PER_POOL), np.float32)
    grown[: values.shape[0], : values.shape[1]] = values
    most = grown.reshape(rows + 1, CELLS_PER_POOL, columns + 1, CELLS_PER_POOL).max(axis=(1, 3))
    return np.maximum.reduce([most[:-1, :-1], most[1:, :-1], most[:-1, 1:], most[1:, 1:]])


def thinned(points: Array, grain: float) -> Array:
    """Points (K, 2) [m] → the first of every square of `grain` [m], in their order."""
    cells = np.floor(points.reshape(-1, 2) / grain).astype(np.int64)
    _, first = np.unique(cells[:, 0] * 1_000_003 + cells[:, 1], return_index=True)
    return points[np.sort(first)]
