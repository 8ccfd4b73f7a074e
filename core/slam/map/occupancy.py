"""The occupancy map: where beams ended and where they passed, for people, planner and export."""

import math
from dataclasses import dataclass
from typing import Annotated

import cv2
import numpy as np

from core.errors import BadInput
from core.geometry import Pose, wrap
from core.message import Array, message
from core.setting import Meta, Section

MOST_CELLS = 5000  # from the world's origin to the map's side: 400 MB in all
FRACTION_BITS = 4  # of a cell, for the outline of what was free


@message
class OccupancyGrid:
    """The occupancy map for people, planner and export. Row 0 lies at the lowest y."""

    revision: int  # rises with every change
    resolution: float  # [m]
    origin: Array  # (2,) [m], world: the outer corner of cell [0, 0]
    log_odds: Array  # (rows, columns) float32; 0 = unknown, > 0 occupied, < 0 free


def grown(grid: OccupancyGrid, low: Array, high: Array) -> OccupancyGrid:
    """The grid with unknown cells around it, so that it reaches from `low` to `high` (2,) [m], world."""
    rows, columns = grid.log_odds.shape
    before = np.maximum(0, np.ceil((grid.origin - low) / grid.resolution)).astype(int)
    end = grid.origin + grid.resolution * np.array([columns, rows])
    after = np.maximum(0, np.ceil((high - end) / grid.resolution)).astype(int)
    if not before.any() and not after.any():
        return grid
    return OccupancyGrid(
        revision=grid.revision,
        resolution=grid.resolution,
        origin=grid.origin - grid.resolution * before,
        log_odds=np.pad(grid.log_odds, ((before[1], after[1]), (before[0], after[0]))),
    )


@dataclass(frozen=True)
class OccupancySettings(Section):
    """Settings of the occupancy map: how a scan changes it.

    Watch:
        resolution: memory, and the width of doors on the map
        widest: the rim of the map; raise it where the room goes on
        farthest: stray cells far outside (then lower it)
    """

    hit: float = 1.2  # log odds for a cell where a beam ended
    free: float = -0.4  # log odds for a cell that a beam passed
    bound: float = 4.0  # log odds that no cell exceeds
    moved: float = 0.03  # [m] move since the last drawn scan until the next is drawn
    turned: float = 0.03  # [rad] turn since the last drawn scan until the next is drawn
    waits: int = 5  # [scans] at one place one scan in so many is drawn: what moves away must vanish
    block: float = 5.0  # [m] length by which the map grows
    resolution: Annotated[float, Meta("m", 0.02, 0.5, "side of a cell", common=True)] = 0.05
    widest: Annotated[float, Meta("m", 5, 250, "distance from the origin beyond which nothing is drawn")] = 100.0
    farthest: Annotated[
        float, Meta("m", 0.5, 100, "length to which a beam is drawn; a longer one is free up to there")
    ] = 20.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.widest > MOST_CELLS * self.resolution:
            raise BadInput(f"widest must not exceed {MOST_CELLS} cells: {MOST_CELLS * self.resolution:g} m.")


class OccupancyMap:
    """Grows with what is seen."""

    def __init__(self, settings: OccupancySettings | None = None) -> None:
        self._settings = settings or OccupancySettings()
        self._origin = np.zeros(2)
        self._log_odds = np.zeros((0, 0), np.float32)
        self._drawn_at: Pose | None = None
        self._waited = 0
        self.revision = 0
        self._grid: OccupancyGrid | None = None

    def insert(self, pose: Pose, ends: Array, hits: Array) -> bool:
        """Beam ends (N, 2) [m], world, right to left, NaN where nothing was measured; which are hits (N,) bool.

        `pose` is where the beams started. Returns whether the scan was drawn: from one place only some are.
        """
        if not self._is_worth_drawing(pose):
            return False
        ends, hits = self._shortened(pose, ends, hits)
        known = np.all(np.abs(np.nan_to_num(ends, nan=np.inf)) < self._settings.widest, axis=1)
        if not known.any() or max(abs(pose.x), abs(pose.y)) >= self._settings.widest:
            return False
        self._make_room(np.vstack((ends[known], (pose.x, pose.y))))
        self._drawn_at, self._waited = pose, 0
        self._draw(pose, ends, known, hits & known)
        self.revision += 1
        self._grid = None
        return True

    def grid(self) -> OccupancyGrid:
        """The map now; the same value until it changes."""
        if self._grid is None:
            self._grid = OccupancyGrid(
                revision=self.revision,
                resolution=self._settings.resolution,
                origin=self._origin,
                log_odds=self._log_odds,
            )
        return self._grid

    def load(self, origin: Array, log_odds: Array) -> None:
        """Take a map that was drawn before: outer corner of the first cell (2,) [m], log odds (rows, columns).

        Raises ValueError where it does not consist of whole blocks.
        """
        block = math.ceil(self._settings.block / self._settings.resolution)
        blocks = origin / (block * self._settings.resolution)
        if np.abs(blocks - np.round(blocks)).max() > 1e-6 or any(side % block for side in log_odds.shape):
            raise ValueError("the map does not consist of whole blocks")
        self._origin, self._log_odds = origin.astype(np.float64), log_odds.astype(np.float32)
        self.revision += 1
        self._grid = None

    @property
    def cells(self) -> tuple[Array, Array]:
        """The map as it is now, to look at and not to keep: origin (2,) [m], log odds (rows, columns)."""
        return self._origin, self._log_odds

    @property
    def resolution(self) -> float:
        """Side of a cell [m]."""
        return self._settings.resolution

    def _shortened(self, pose: Pose, ends: Array, hits: Array) -> tuple[Array, Array]:
        away = ends - (pose.x, pose.y)
        length = np.hypot(away[:, 0], away[:, 1])
        far = (length > self._settings.farthest) & (length < self._settings.widest)
        if not far.any():
            return ends, hits
        share = np.where(far, self._settings.farthest / np.where(far, length, 1.0), 1.0)
        return away * share[:, None] + (pose.x, pose.y), hits & ~far

    def _is_worth_drawing(self, pose: Pose) -> bool:
        last, settings = self._drawn_at, self._settings
        if last is None:
            return True
        self._waited += 1
        return (
            pose.distance_to(last.x, last.y) > settings.moved
            or abs(wrap(pose.heading - last.heading)) > settings.turned
            or self._waited >= settings.waits
        )

    def _draw(self, pose: Pose, ends: Array, known: Array, hits: Array) -> None:
        """Free inside the outline of the beams, occupied where they ended."""
        cell, settings = self._settings.resolution, self._settings
        start = (np.array([pose.x, pose.y]) - self._origin) / cell
        outline = np.where(known[:, None], (ends - self._origin) / cell, start)
        low = np.floor(np.minimum(outline.min(axis=0), start)).astype(int) - 1
        high = np.ceil(np.maximum(outline.max(axis=0), start)).astype(int) + 2
        low, high = np.maximum(low, 0), np.minimum(high, self._log_odds.shape[::-1])
        passed = np.zeros((high[1] - low[1], high[0] - low[0]), np.uint8)
        corners = np.round((np.vstack((start, outline)) - low - 0.5) * (1 << FRACTION_BITS)).astype(np.int32)
        cv2.fillPoly(passed, [corners], 1, lineType=cv2.LINE_8, shift=FRACTION_BITS)
        ended = np.floor((ends[hits] - self._origin) / cell).astype(int) - low
        passed[ended[:, 1], ended[:, 0]] = 2
        change = np.array([0.0, settings.free, settings.hit], np.float32)[passed]
        part = self._log_odds[low[1] : high[1], low[0] : high[0]]
        np.clip(part + change, -settings.bound, settings.bound, out=part)

    def _make_room(self, points: Array) -> None:
        """Grow by whole blocks until all points (N, 2) [m] lie inside."""
        settings = self._settings
        block = math.ceil(settings.block / settings.resolution)
        size = block * settings.resolution
        low = np.floor((points.min(axis=0) - settings.resolution) / size).astype(int)
        high = np.floor((points.max(axis=0) + settings.resolution) / size).astype(int) + 1
        rows, columns = self._log_odds.shape
        if rows:
            was_low = np.round(self._origin / size).astype(int)
            was_high = was_low + np.array([columns // block, rows // block])
            low, high = np.minimum(low, was_low), np.maximum(high, was_high)
            if (low == was_low).all() and (high == was_high).all():
                return
        grown = np.zeros(((high[1] - low[1]) * block, (high[0] - low[0]) * block), np.float32)
        if rows:
            column, row = (np.round(self._origin / size).astype(int) - low) * block
            grown[row : row + rows, column : column + columns] = self._log_odds
        self._log_odds, self._origin = grown, low * size
