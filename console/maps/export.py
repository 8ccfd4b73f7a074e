"""Exports of a saved map next to Beckon's own files: files for other programs, and a picture for the list."""

from pathlib import Path

import cv2
import numpy as np

from console.scene.overlays.occupancy import paint
from core.files import write_atomic
from core.geometry import Pose
from core.message import Array
from core.pipelines.nav2_map import nav2_map
from core.slam.map.map_file import SavedMap
from core.slam.map.occupancy import OccupancyGrid

FLOOR = "floor"  # folder of what the pilot goes on with
PREVIEW = "preview.png"
SHOWN_LOG_ODDS = 0.6  # from which a cell is drawn as a wall
SHOWN_OLDER, SHOWN_NEWER = (40, 52, 64), (220, 60, 40)  # red, green, blue
MAX_SIDE_PX = 640  # picture elements along a side of the preview


def write_map(folder: Path, saved: SavedMap, grid: OccupancyGrid, landmarks: str, trajectory: str) -> None:
    """All files of a map; landmarks as CSV, the trajectory as TUM. Raises OSError."""
    inner = folder / FLOOR
    inner.mkdir()
    saved.to_files(inner)
    text, picture = nav2_map(grid)
    write_atomic(folder / "map.yaml", text)
    write_atomic(folder / "map.pgm", picture)
    write_atomic(folder / "landmarks.csv", landmarks)
    write_atomic(folder / "trajectory.tum", trajectory)
    write_atomic(folder / PREVIEW, preview(grid))


def known_part(grid: OccupancyGrid) -> OccupancyGrid:
    """A grid cut to its known cells. Raises ValueError when nothing is known."""
    rows, columns = (np.flatnonzero((grid.log_odds != 0).any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        raise ValueError("Nothing of this grid is known.")
    corner = np.array([columns[0], rows[0]])
    return OccupancyGrid(
        revision=grid.revision,
        resolution=grid.resolution,
        origin=grid.origin + grid.resolution * corner,
        log_odds=grid.log_odds[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1],
    )


def preview(grid: OccupancyGrid) -> bytes:
    """Return the known part of a grid as a small PNG; unknown cells are transparent."""
    picture = paint(known_part(grid))
    rows, columns = picture.shape[:2]
    scale = MAX_SIDE_PX / max(rows, columns)
    if scale < 1:
        size = (max(1, round(scale * columns)), max(1, round(scale * rows)))
        picture = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    return png(picture)


def overlay(older: OccupancyGrid, newer: OccupancyGrid, older_from_newer: Pose) -> bytes:
    """Two maps over each other as a PNG: the walls of the older one dark, of the newer one red where they differ."""
    first, second = known_part(older), known_part(newer)
    cell = first.resolution
    grids = ((first, Pose(), SHOWN_OLDER), (second, older_from_newer, SHOWN_NEWER))
    drawn = [
        (pose.apply(grid.origin + (np.argwhere(grid.log_odds > SHOWN_LOG_ODDS)[:, ::-1] + 0.5) * cell), colour)
        for grid, pose, colour in grids
    ]
    points = np.vstack([places for places, _ in drawn])
    low = np.floor(points.min(axis=0) / cell).astype(int) - 2
    columns, rows = np.ceil(points.max(axis=0) / cell).astype(int) + 3 - low
    picture = np.full((rows, columns, 4), 255, np.uint8)
    for places, colour in reversed(drawn):
        column, row = (np.floor(places / cell).astype(int) - low).T
        picture[rows - 1 - row, column, :3] = colour
    return png(picture)


def png(picture: Array) -> bytes:
    """Picture (H, W, 4) uint8, red first → PNG."""
    _, packed = cv2.imencode(".png", cv2.cvtColor(picture, cv2.COLOR_RGBA2BGRA))
    return packed.tobytes()
