"""Trace an occupancy grid: walls and free floor as polygons, to be drawn at any scale.

A wall in the grid is one to three cells thick, as beams happened to fall: it is drawn as a plan has it, by strokes of
one width along its middle. What is thicker (a pillar, a filled block of a map drawn elsewhere) keeps its shape.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from core.message import Array
from core.slam.map.occupancy import OccupancyGrid

WALL_FINENESS, FLOOR_FINENESS = 4, 2  # picture elements along a cell while tracing
MAX_TRACED_PX = 2400  # along a side; above it the tracing is coarser
EVIDENCE_BOUND = 2.0  # log odds: more evidence makes no wall thicker
WALL_BLUR_CELLS, FLOOR_BLUR_CELLS = 0.55, 0.9
WALL_EVIDENCE, FLOOR_EVIDENCE = 0.9, 0.3  # of the smoothed log odds, at the edge
JOINED_GAP_CELLS = 2  # between two pieces of a wall that are drawn as one
STROKE_CELLS, SOLID_CELLS = 2.0, 6  # width of a wall's stroke; what is wider than the second is no stroke
MAX_BEND_CELLS = 0.9  # of a stroke from the middle of its wall
WALL_DEVIATION_CELLS, FLOOR_DEVIATION_CELLS = 0.28, 0.35  # of a polygon from the edge that it follows
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
    return MapOutline(_walls(grid, wall), _floor(grid, free))


def _walls(grid: OccupancyGrid, evidence: Array) -> tuple[Array, ...]:
    """Return the rings around the strokes and the solid parts of the walls."""
    raster = _raster(grid, evidence, WALL_FINENESS, WALL_BLUR_CELLS, WALL_EVIDENCE, margin=2 + JOINED_GAP_CELLS)
    if raster is None:
        return ()
    fineness = raster.fineness
    inside: Array = cv2.morphologyEx(raster.inside, cv2.MORPH_CLOSE, raster.disc(JOINED_GAP_CELLS))
    _, found, figures, _ = cv2.connectedComponentsWithStats(inside)
    pieces = np.asarray(found, np.int32)
    inside &= (figures[:, cv2.CC_STAT_AREA] > MIN_WALL_CELLS * fineness**2)[pieces]
    lines = _thinned(inside)
    drawn: Array = cv2.morphologyEx(inside, cv2.MORPH_OPEN, raster.disc(SOLID_CELLS))
    drawn |= inside & ~np.isin(pieces, pieces[lines > 0])  # a small square has no line
    # a contour goes along one side of a line and back along the other, around every branch
    for line in cv2.findContours(lines, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)[0]:
        stroke = cv2.approxPolyDP(line, MAX_BEND_CELLS * fineness, True)
        cv2.polylines(drawn, [stroke], True, 1, max(1, round(STROKE_CELLS * fineness)))
    return raster.rings(drawn, WALL_DEVIATION_CELLS, MIN_WALL_CELLS)


def _floor(grid: OccupancyGrid, evidence: Array) -> tuple[Array, ...]:
    raster = _raster(grid, evidence, FLOOR_FINENESS, FLOOR_BLUR_CELLS, FLOOR_EVIDENCE, margin=2)
    return () if raster is None else raster.rings(raster.inside, FLOOR_DEVIATION_CELLS, MIN_FLOOR_CELLS)


@dataclass(frozen=True)
class _Raster:
    """The part of a grid that holds evidence, finer and smoothed."""

    inside: Array  # (H, W) uint8: 1 where there is enough evidence
    fineness: int  # picture elements along a cell
    corner: Array  # (2,) [m], world: of the picture
    resolution: float  # [m] of a cell

    def disc(self, cells: int) -> Array:
        return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (cells * self.fineness + 1,) * 2)

    def rings(self, picture: Array, deviation: float, smallest: float) -> tuple[Array, ...]:
        """Return the rings [m] around more than `smallest` cells, at most `deviation` [cells] from their edge."""
        rings, _ = cv2.findContours(picture, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
        large = (ring for ring in rings if cv2.contourArea(ring) > smallest * self.fineness**2)
        simple = (cv2.approxPolyDP(ring, deviation * self.fineness, True).reshape(-1, 2) for ring in large)
        element = self.resolution / self.fineness
        return tuple(self.corner + element * (ring + 0.5) for ring in simple if len(ring) > 2)


def _raster(
    grid: OccupancyGrid, evidence: Array, finest: int, blur: float, above: float, margin: int
) -> _Raster | None:
    """Return where smoothed evidence exceeds `above`, `margin` cells around it (lengths in cells); None: nowhere."""
    rows, columns = (np.flatnonzero(evidence.any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        return None
    part = np.pad(evidence[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1], margin).astype(np.float32)
    fineness = max(1, min(finest, MAX_TRACED_PX // max(part.shape)))
    field = cv2.resize(part, None, fx=fineness, fy=fineness, interpolation=cv2.INTER_LINEAR)
    inside = (cv2.GaussianBlur(field, (0, 0), blur * fineness) > above).astype(np.uint8)
    corner = grid.origin + grid.resolution * (np.array([columns[0], rows[0]]) - margin)
    return _Raster(inside, fineness, corner, grid.resolution)


def _thinned(inside: Array) -> Array:
    """Return the lines in the middle of what is 1, one element wide (Zhang and Suen, 1984)."""
    lines = inside.copy()
    while True:
        before = np.count_nonzero(lines)
        for removable in _REMOVABLE:
            around = cv2.filter2D(lines, cv2.CV_8U, _NEIGHBOURS, borderType=cv2.BORDER_CONSTANT)
            lines &= np.invert(cv2.LUT(around, removable))
        if np.count_nonzero(lines) == before:
            return lines


def _removable() -> tuple[Array, Array]:
    """Return for each set of neighbours (256,) whether the element goes: from south and east, then north and west."""
    bits = (np.arange(256)[:, None] >> np.arange(8)) & 1  # clockwise from the north
    north, east, south, west = bits[:, 0], bits[:, 2], bits[:, 4], bits[:, 6]
    count, begins = bits.sum(axis=1), ((bits == 0) & (np.roll(bits, -1, axis=1) == 1)).sum(axis=1)
    edge = (count >= 2) & (count <= 6) & (begins == 1)
    first, second = (north & east & south) | (east & south & west), (north & east & west) | (north & south & west)
    return (edge & (first == 0)).astype(np.uint8), (edge & (second == 0)).astype(np.uint8)


_NEIGHBOURS = np.array([[128, 1, 2], [64, 0, 4], [32, 16, 8]], np.float32)  # one bit each
_REMOVABLE = _removable()
