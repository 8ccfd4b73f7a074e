"""Zones as Nav2's filter masks, and masks as zones: keep-out and speed filter.

A mask's cell belongs to a zone that covers any of it; a mask that is read becomes polygons along the edges of its
cells, so that both ways lead back to the same cells. Fields of the filters: Nav2's CostmapFilterInfo, value = base +
multiplier · cell; type 0 keep-out, 1 speed in % of the robot's largest, 2 speed in m/s.
"""

import math
from collections.abc import Iterable, Sequence
from typing import Literal

import cv2
import numpy as np

from core.errors import BadInput
from core.message import Array
from core.navigation.zones import MapZone
from core.pipelines.nav2_map import FREE_PIXEL, OCCUPIED_PIXEL, OCCUPIED_VALUE, Nav2Cells, map_yaml, pgm
from core.sentences import Statement
from core.slam.map.edits import within
from core.slam.map.occupancy import OccupancyGrid

SpeedType = Literal[1, 2]

SLACK_M = 0.0015  # by which a zone may reach into a cell that it does not touch: zones are kept in millimetres
MAX_LIMIT_M_S = 10.0  # of a slow zone: more is a share in percent
SPEED_STEP_M_S = 0.01  # of a cell's value in the speed mask
MAX_RING_CORNERS = 200
MAX_TURN_RAD = 1e-6  # of an origin that is as good as straight
MAX_AROUND_M = 50.0  # by which a mask is larger than its map, to hold zones
PARAMETERS = """\
# Into nav2_params.yaml; keepout_filter belongs into `plugins` before inflation_layer, or its edge is not inflated.
keepout_filter_mask_server:
  ros__parameters: {yaml_filename: keepout_mask.yaml, topic_name: /keepout_filter_mask}
keepout_costmap_filter_info_server:
  ros__parameters: {type: 0, filter_info_topic: /keepout_costmap_filter_info, mask_topic: /keepout_filter_mask, \
base: 0.0, multiplier: 1.0}
speed_filter_mask_server:
  ros__parameters: {yaml_filename: speed_mask.yaml, topic_name: /speed_filter_mask}
speed_costmap_filter_info_server:
  ros__parameters: {type: 2, filter_info_topic: /speed_costmap_filter_info, mask_topic: /speed_filter_mask, \
base: 0.0, multiplier: 0.01}
"""


def mask_files(zones: Iterable[MapZone], grid: OccupancyGrid) -> dict[str, bytes]:
    """The masks of all zones on the lattice of a map, grown by 50 m at most to hold them, and Nav2's parameters."""
    drawn = list(zones)
    lattice = _around(grid, drawn)
    keep_out = np.full(lattice.log_odds.shape, FREE_PIXEL, np.uint8)
    speed = np.zeros(lattice.log_odds.shape, np.uint8)
    for zone in drawn:
        cells = covered(zone.points, lattice)
        if zone.max_speed is None:
            keep_out[cells] = OCCUPIED_PIXEL
            continue
        value = max(1, min(OCCUPIED_VALUE, math.floor(zone.max_speed / SPEED_STEP_M_S + 1e-6)))
        speed[cells] = np.where(speed[cells] == 0, value, np.minimum(speed[cells], value))
    return {
        "keepout_mask.yaml": map_yaml(lattice, "keepout_mask.pgm", "trinary").encode(),
        "keepout_mask.pgm": pgm(keep_out[::-1]),
        "speed_mask.yaml": map_yaml(lattice, "speed_mask.pgm", "raw").encode(),
        "speed_mask.pgm": pgm(speed[::-1]),
        "nav2_params.yaml": PARAMETERS.encode(),
    }


def keep_out_polygons(mask: Nav2Cells) -> tuple[list[Array], int]:
    """Polygons (N, 2) [m] around the cells of 100, and how many lie between: they only cost more."""
    _check_straight(mask)
    between = int(((mask.values > 0) & (mask.values < OCCUPIED_VALUE)).sum())
    return rings(mask.values == OCCUPIED_VALUE, mask), between


def slow_polygons(
    mask: Nav2Cells, kind: SpeedType, base: float, multiplier: float, largest: float
) -> tuple[list[tuple[Array, float]], int]:
    """Polygons with their limit [m/s], and how many cells have none; `largest` [m/s]: of the robot.

    Nav2 takes a result of 0, or one out of bounds, for no limit: such cells are left out, and counted. Raises
    BadInput for limits that are no speeds.
    """
    _check_straight(mask)
    found: list[tuple[Array, float]] = []
    without = 0
    for value in np.unique(mask.values[mask.values > 0]).tolist():
        result = base + multiplier * value
        limit = result / 100.0 * largest if kind == 1 else result
        cells = mask.values == value
        if kind == 2 and limit > MAX_LIMIT_M_S:
            raise BadInput(Statement("nav2.fast_mask", limit=f"{limit:g}"))
        if limit <= 0.0 or (kind == 1 and result > 100.0):
            without += int(cells.sum())
            continue
        found += [(ring, limit) for ring in rings(cells, mask)]
    return found, without


def beside(ring: Array, grid: OccupancyGrid) -> bool:
    """Return whether a polygon (N, 2) [m] lies wholly outside the rectangle of a map."""
    end = grid.origin + grid.resolution * np.array(grid.log_odds.shape[::-1])
    return bool((ring.max(axis=0) <= grid.origin).any() or (ring.min(axis=0) >= end).any())


def covered(points: Array, grid: OccupancyGrid) -> Array:
    """Mask (rows, columns) of the cells of which a polygon (N, 2) [m] covers more than `SLACK_M` at an edge."""
    rows, columns = grid.log_odds.shape
    mask = np.zeros((rows, columns), bool)
    corners = (points - grid.origin) / grid.resolution
    slack = SLACK_M / grid.resolution
    if (corners.max(axis=0) < 0).any() or (corners.min(axis=0) > (columns, rows)).any():
        return mask
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        spots = _within_cells(start, end, slack)
        inside = ((spots >= 0) & (spots < (columns, rows))).all(axis=1)
        mask[spots[inside, 1], spots[inside, 0]] = True
    low = np.clip(np.floor(corners.min(axis=0)).astype(int), 0, (columns, rows))
    high = np.clip(np.ceil(corners.max(axis=0)).astype(int), 0, (columns, rows))
    if (high > low).all():
        middles = np.indices((high - low)[::-1])[::-1].reshape(2, -1).T + low + 0.5
        mask[low[1] : high[1], low[0] : high[0]] |= within(corners, *middles.T).reshape((high - low)[::-1])
    return mask


def rings(cells: Array, mask: Nav2Cells) -> list[Array]:
    """Polygons (N, 2) [m] along the edges of cells (rows, columns) bool; together they cover these and no others.

    None has a hole: what has one, or too many corners, is cut in two.
    """
    waiting, found = [cells], []
    while waiting:
        _, labels = cv2.connectedComponents(waiting.pop().astype(np.uint8), connectivity=4)
        for number in range(1, int(labels.max()) + 1):
            piece = labels == number
            cut = _cut(piece)
            if cut is not None:
                waiting += cut
                continue
            ring = _ring(piece)
            if len(ring) > MAX_RING_CORNERS:
                waiting += _halves(piece)
                continue
            found.append(np.array(mask.origin[:2]) + mask.resolution * ring)
    return sorted(found, key=lambda ring: tuple(ring.min(axis=0).tolist()))


def _check_straight(mask: Nav2Cells) -> None:
    if abs(math.remainder(mask.origin[2], math.tau)) > MAX_TURN_RAD:
        raise BadInput(Statement("nav2.turned_mask"))


def _around(grid: OccupancyGrid, zones: Sequence[MapZone]) -> OccupancyGrid:
    """The lattice of a grid, grown by whole cells until it holds all zones."""
    cell, shape = grid.resolution, np.array(grid.log_odds.shape[::-1])
    points = np.vstack([zone.points for zone in zones]) if zones else np.zeros((0, 2))
    inner = np.clip((points - grid.origin) / cell, -MAX_AROUND_M / cell, shape + MAX_AROUND_M / cell)
    low = np.floor(inner.min(axis=0, initial=0.0) + SLACK_M / cell).astype(int)
    high = np.ceil(np.maximum(inner.max(axis=0, initial=0.0), shape) - SLACK_M / cell).astype(int)
    empty = np.zeros((high - low)[::-1], np.float32)
    return OccupancyGrid(revision=grid.revision, resolution=cell, origin=grid.origin + low * cell, log_odds=empty)


def _within_cells(start: Array, end: Array, slack: float) -> Array:
    """Cells (K, 2) column, row whose inner part, `slack` from its edges, a segment passes; in cells."""
    way = end - start
    crossings = [np.array([0.0, 1.0])]
    for axis in (0, 1):
        if abs(way[axis]) > 1e-12:
            low, high = sorted((start[axis], end[axis]))
            lines = np.arange(math.ceil(low), math.floor(high) + 1)
            edges = np.concatenate([lines, lines - slack, lines + slack])
            crossings.append((edges - start[axis]) / way[axis])
    shares = np.unique(np.concatenate(crossings).clip(0.0, 1.0))
    middles = start + (0.5 * (shares[:-1] + shares[1:]))[:, None] * way
    cells = np.floor(middles)
    aside = middles - cells
    return cells[((aside > slack) & (aside < 1.0 - slack)).all(axis=1)].astype(int)


def _cut(piece: Array) -> list[Array] | None:
    """A piece with a hole → the same in two, cut through the hole; None where it has none."""
    outside = np.pad(~piece, 1, constant_values=True).astype(np.uint8)
    count, labels = cv2.connectedComponents(outside, connectivity=8)
    if count <= 2:
        return None
    hole = labels[1:-1, 1:-1] == next(k for k in range(1, count) if k != labels[0, 0])
    return _split(piece, int(np.flatnonzero(hole.any(axis=0))[0]), axis=1)


def _halves(piece: Array) -> list[Array]:
    spans = [np.flatnonzero(piece.any(axis=1 - axis)) for axis in (0, 1)]
    axis = int(len(spans[1]) > len(spans[0]))
    return _split(piece, int(spans[axis][len(spans[axis]) // 2]), axis)


def _split(piece: Array, at: int, axis: int) -> list[Array]:
    before = np.arange(piece.shape[axis]) < max(at, 1)
    part = before[:, None] if axis == 0 else before[None, :]
    return [piece & part, piece & ~part]


def _ring(piece: Array) -> Array:
    padded = np.pad(piece, 1)
    inner = padded[1:-1, 1:-1]
    sides = {
        (1, 0): (inner & ~padded[:-2, 1:-1], (0, 0)),  # its lower edge leads to the right
        (0, 1): (inner & ~padded[1:-1, 2:], (1, 0)),
        (-1, 0): (inner & ~padded[2:, 1:-1], (1, 1)),
        (0, -1): (inner & ~padded[1:-1, :-2], (0, 1)),
    }
    leads: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for way, (edges, corner) in sides.items():
        for row, column in np.argwhere(edges).tolist():
            leads.setdefault((column + corner[0], row + corner[1]), []).append(way)
    start = min(leads, key=lambda corner: (corner[1], corner[0]))
    at, way = start, leads[start][0]
    corners: list[tuple[int, int]] = []
    while not corners or at != start or way != leads[start][0]:
        left = (-way[1], way[0])
        turn = left if left in leads[at] else next(one for one in leads[at])
        if turn != way or not corners:
            corners.append(at)
        way = turn
        at = at[0] + way[0], at[1] + way[1]
        if at == start:
            break
    return np.array(corners, float)
