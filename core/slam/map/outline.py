"""Trace an occupancy grid: walls and free floor as polygons, to be drawn at any scale."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from core.message import Array
from core.slam.map.occupancy import OccupancyGrid

WALL_FINENESS, FLOOR_FINENESS = 4, 2  # picture elements along a cell while tracing
MAX_TRACED_PX = 3200  # along a side; above it the tracing is coarser
EVIDENCE_BOUND = 2.0  # log odds: more evidence makes no wall thicker
WALL_BLUR_CELLS, FLOOR_BLUR_CELLS = 0.55, 0.9
WALL_EVIDENCE, FLOOR_EVIDENCE = 0.9, 0.3  # of the smoothed log odds, at the edge
JOINED_GAP_CELLS = 2  # between two pieces of a wall that are drawn as one
MAX_DEVIATION_CELLS = 0.35  # of a polygon from the edge that it follows
MIN_WALL_CELLS, MIN_FLOOR_CELLS = 1.5, 12.0  # smaller pieces are noise


@dataclass(frozen=True)
class MapOutline:
    """Polygons (N, 2) [m], world; an inner ring is a hole (even-odd rule).

    `walls` encloses occupied cells; `floor` those that a beam passed, and the walls that border them.
    """

    walls: tuple[Array, ...]
    floor: tuple[Array, ...]

    @property
    def extent(self) -> tuple[float, float, float, float] | None:
        """Left, bottom, right and top of the walls, without any of the floor [m]; None where nothing is drawn."""
        rings = self.walls or self.floor
        if not rings:
            return None
        points = np.concatenate(rings)
        (left, bottom), (right, top) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
        return left, bottom, right, top


def trace_outline(grid: OccupancyGrid) -> MapOutline:
    """Grid → its outline; gaps in a wall of up to `JOINED_GAP_CELLS` are closed."""
    odds = np.clip(grid.log_odds, -EVIDENCE_BOUND, EVIDENCE_BOUND)
    wall, free = np.maximum(odds, 0.0), np.where(odds > 0, EVIDENCE_BOUND, -odds)
    return MapOutline(
        _traced(grid, wall, WALL_FINENESS, WALL_BLUR_CELLS, WALL_EVIDENCE, MIN_WALL_CELLS, JOINED_GAP_CELLS),
        _traced(grid, free, FLOOR_FINENESS, FLOOR_BLUR_CELLS, FLOOR_EVIDENCE, MIN_FLOOR_CELLS, 0),
    )


def _traced(
    grid: OccupancyGrid, evidence: Array, finest: int, blur: float, above: float, smallest: float, gap: int
) -> tuple[Array, ...]:
    """Return the rings around what has more evidence than `above` (lengths in cells)."""
    rows, columns = (np.flatnonzero(evidence.any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        return ()
    margin = 2 + gap
    part = np.pad(evidence[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1], margin).astype(np.float32)
    fineness = max(1, min(finest, MAX_TRACED_PX // max(part.shape)))
    field = cv2.resize(part, None, fx=fineness, fy=fineness, interpolation=cv2.INTER_LINEAR)
    inside = (cv2.GaussianBlur(field, (0, 0), blur * fineness) > above).astype(np.uint8)
    if gap:
        disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (gap * fineness + 1,) * 2)
        inside = cv2.morphologyEx(inside, cv2.MORPH_CLOSE, disc)
    rings, _ = cv2.findContours(inside, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    corner = grid.origin + grid.resolution * (np.array([columns[0], rows[0]]) - margin)
    return tuple(
        corner + (grid.resolution / fineness) * (ring.reshape(-1, 2) + 0.5)
        for ring in _simplified(rings, fineness, smallest)
    )


def _simplified(rings: Sequence[Array], fineness: int, smallest: float) -> list[Array]:
    """Return the rings of more than `smallest` cells with as few corners as `MAX_DEVIATION_CELLS` allows."""
    large = (ring for ring in rings if cv2.contourArea(ring) > smallest * fineness**2)
    simple = (cv2.approxPolyDP(ring, MAX_DEVIATION_CELLS * fineness, True) for ring in large)
    return [ring for ring in simple if len(ring) > 2]
