"""A map that was drawn elsewhere as one to go on in: its cells as submaps, with the views that they would show.

The scan layer matches scans to views; a drawn map has none. So a view is cast from every metre of its free floor:
what a laser that turns all around would see there. Submaps are squares of the floor: none is left at its rim.
"""

import math

import cv2
import numpy as np

from core.errors import BadInput
from core.message import Array
from core.sentences import Statement
from core.slam.map.map_file import FORM_NUMBER, MapFacts, SavedMap
from core.slam.map.occupancy import OccupancyGrid, OccupancySettings
from core.slam.map.submap import SubmapSettings

OCCUPIED_LOG_ODDS, FREE_LOG_ODDS = 0.6, -0.3  # as the search for the robot's place has it
VIEW_SPACING_M = 1.0
ROOM_AROUND_VIEW_M = 0.25
BEAMS_PER_VIEW = 240
REACH_M = 8.0
EDGE_SD = (0.01, 0.01, 0.002)  # [m], [m], [rad] between views: what was drawn does not bend
MIN_VIEW_HITS = 30  # beams of a view that end on something: with fewer nothing can be matched


def drawn_map(grid: OccupancyGrid, occupancy: OccupancySettings, floor: SubmapSettings) -> SavedMap:
    """Grid, its lattice on multiples of the cell → the same as a saved map. Raises BadInput where none can stand."""
    edges = np.vstack((grid.origin, grid.origin + grid.resolution * np.array(grid.log_odds.shape[::-1])))
    if np.abs(edges).max() > occupancy.widest:
        raise BadInput(Statement("nav2.beyond", metres=f"{occupancy.widest:g}"))
    places, ends, hits = _views(grid)
    if not len(places):
        raise BadInput(Statement("nav2.nowhere"))
    block = math.ceil(occupancy.block / grid.resolution)
    side = min(block, math.floor(math.sqrt(2.0) * (floor.size - floor.inside) / grid.resolution))
    centres, homes = _squares(places, max(2, side) * grid.resolution, grid.resolution)
    order = np.argsort(homes, kind="stable")
    places, ends, hits, homes = places[order], ends[order], hits[order], homes[order]
    arrays = _view_arrays(places, ends, hits, homes, centres)
    for number, (centre, (origin, tile)) in enumerate(zip(centres, _tiles(grid, centres, block), strict=True)):
        first = int(np.argmax(homes == number))
        arrays[f"tile_{number}"], arrays[f"origin_{number}"] = tile, origin
        arrays[f"places_{number}"], arrays[f"covariance_{number}"] = np.zeros((0, 2)), np.zeros((3, 3))
        arrays[f"pose_{number}"] = np.append(places[first] - centre, 0.0)
    facts = MapFacts(form=FORM_NUMBER, resolution_m=grid.resolution, landmarks=[[] for _ in centres], closures=[])
    return SavedMap(arrays=arrays, facts=facts)


def _views(grid: OccupancyGrid) -> tuple[Array, Array, Array]:
    """Places (V, 2) [m], world, with ends (V, N, 2) [m] of beams all around, as seen there, and hits (V, N)."""
    free = grid.log_odds < FREE_LOG_ODDS
    room = cv2.distanceTransform(np.pad(free, 1).astype(np.uint8), cv2.DIST_L2, 5)[1:-1, 1:-1] * grid.resolution
    rows, columns = np.nonzero(room >= ROOM_AROUND_VIEW_M)
    step = max(1, round(VIEW_SPACING_M / grid.resolution))
    squares = (rows // step) * (free.shape[1] // step + 1) + columns // step
    roomy = np.lexsort((-room[rows, columns], squares))
    _, first = np.unique(squares[roomy], return_index=True)
    rows, columns = rows[roomy[first]], columns[roomy[first]]
    places = grid.origin + (np.column_stack((columns, rows)) + 0.5) * grid.resolution
    cast = [_cast(grid, place) for place in places]
    kept = [k for k, (_, hit) in enumerate(cast) if int(hit.sum()) >= MIN_VIEW_HITS]
    if not kept:
        return np.zeros((0, 2)), np.zeros((0, 0, 2)), np.zeros((0, 0), bool)
    return places[kept], np.array([cast[k][0] for k in kept]), np.array([cast[k][1] for k in kept])


def _cast(grid: OccupancyGrid, place: Array) -> tuple[Array, Array]:
    """Ends (N, 2) [m], seen from a place, NaN where a beam leaves what is known; which are hits (N,) bool."""
    angles = math.tau * np.arange(BEAMS_PER_VIEW) / BEAMS_PER_VIEW - math.pi
    rays = np.column_stack((np.cos(angles), np.sin(angles)))
    along = np.arange(0.5, REACH_M / grid.resolution, 0.5) * grid.resolution
    cells = np.floor((place - grid.origin + along[:, None] * rays[:, None]) / grid.resolution).astype(int)
    height, width = grid.log_odds.shape
    inside = (cells[..., 0] >= 0) & (cells[..., 0] < width) & (cells[..., 1] >= 0) & (cells[..., 1] < height)
    odds = np.where(inside, grid.log_odds[cells[..., 1].clip(0, height - 1), cells[..., 0].clip(0, width - 1)], 0.0)
    wall, passed = odds > OCCUPIED_LOG_ODDS, odds < 0.0
    ends_at = np.where(passed.all(axis=1), len(along) - 1, np.argmin(passed, axis=1))
    hit = wall[np.arange(len(rays)), ends_at]
    ends = along[ends_at][:, None] * rays
    ends[~hit & ~passed.all(axis=1)] = np.nan
    return ends, hit


def _squares(places: Array, side: float, cell: float) -> tuple[Array, Array]:
    """Places (V, 2) → the middles (K, 2) [m] of the squares that hold any, on the lattice, and each one's (V,)."""
    which, homes = np.unique(np.floor(places / side).astype(int), axis=0, return_inverse=True)
    return np.rint((which + 0.5) * side / cell) * cell, homes.ravel()


def _view_arrays(places: Array, ends: Array, hits: Array, homes: Array, centres: Array) -> dict[str, Array]:
    views, beams = len(places), ends.shape[1]
    covariance = np.diag(EDGE_SD) ** 2
    poses = np.column_stack((places, np.zeros(views)))
    ways = [np.hypot(*(places[:b] - places[b]).T) for b in range(1, views)]  # to the views before
    ties = [(int(a), b) for b, way in enumerate(ways, 1) for a in np.argsort(way, kind="stable")[:2]]
    tied = np.array(ties, np.int64).reshape(-1, 2)
    return {
        "view_stamps": np.zeros(views),
        "view_submaps": homes.astype(np.int64),
        "view_locals": np.column_stack((places - centres[homes], np.zeros(views))),
        "view_poses": poses,
        "view_eyes": np.zeros((views, 2)),
        "view_beams": np.full(views, beams, np.int64),
        "beam_ends": ends.reshape(-1, 2).astype(np.float32),
        "beam_hits": hits.reshape(-1),
        "driven_moves": np.diff(poses, axis=0),
        "driven_covariances": np.tile(covariance, (views - 1, 1, 1)),
        "tied_ends": tied,
        "tied_moves": poses[tied[:, 1]] - poses[tied[:, 0]],
        "tied_covariances": np.tile(covariance, (len(tied), 1, 1)),
        "link_ends": np.zeros((0, 3), np.int64),
        "link_moves": np.zeros((0, 3)),
        "link_covariances": np.zeros((0, 3, 3)),
        "link_scores": np.zeros((0, 2)),
    }


def _tiles(grid: OccupancyGrid, centres: Array, block: int) -> list[tuple[Array, Array]]:
    """For each submap the outer corner (2,) [m] of its tile, in its frame, and the log odds of its cells."""
    cell, size = grid.resolution, block * grid.resolution
    rows, columns = np.nonzero(grid.log_odds)
    middles = grid.origin + (np.column_stack((columns, rows)) + 0.5) * cell
    nearest = np.zeros(len(middles), np.int64)
    least = np.full(len(middles), np.inf)
    for number, centre in enumerate(centres):
        away = np.abs(middles - centre).max(axis=1)
        nearest[away < least] = number
        least = np.minimum(least, away)
    tiles: list[tuple[Array, Array]] = []
    for number, centre in enumerate(centres):
        own = nearest == number
        inner = middles[own] - centre
        low = np.floor(inner.min(axis=0, initial=0.0) / size).astype(int)
        high = np.floor(inner.max(axis=0, initial=0.0) / size).astype(int) + 1
        tile = np.zeros((high - low)[::-1] * block, np.float32)
        column, row = np.floor(inner / cell - low * block + 1e-6).astype(int).T
        tile[row, column] = grid.log_odds[rows[own], columns[own]]
        tiles.append((low * size, tile))
    return tiles
