"""Exports of a saved map next to Beckon's own files: files for other programs, and a picture for the list."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

import cv2
import numpy as np

from console.scene.overlays.occupancy import paint
from core.files import write_atomic
from core.message import Array
from core.pipelines.nav2_map import nav2_map
from core.slam.map.occupancy import OccupancyGrid

FLOOR = "floor"  # folder of what the pilot goes on with
PREVIEW = "preview.png"
MAX_SIDE_PX = 640  # picture elements along a side of the preview


class MapWriter(Protocol):
    """Something that puts itself into a folder."""

    def to_files(self, folder: Path) -> None:
        """Write everything; the folder exists."""
        ...


def write_map(folder: Path, saved: MapWriter, grid: OccupancyGrid, landmarks: str, trajectory: str) -> None:
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


def png(picture: Array) -> bytes:
    """Picture (H, W, 4) uint8, red first → PNG."""
    _, packed = cv2.imencode(".png", cv2.cvtColor(picture, cv2.COLOR_RGBA2BGRA))
    return packed.tobytes()
