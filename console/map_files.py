"""What lies in a saved map beside what Beckon itself reads: files for other programs, and a picture for the list."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

import cv2
import numpy as np

from console.journey import laid_out
from console.scene.occupancy import paint
from core.experiments.offline_files import landmarks_csv, trajectory_tum
from core.files import write_atomic
from core.message import Array
from core.navigation.nav2_map import nav2_map
from core.slam.occupancy import Grid
from core.snapshot import Snapshot

FLOOR = "floor"  # folder of what the pilot goes on with
PREVIEW = "preview.png"
WIDEST = 640  # picture elements along a side of the preview


class Writes(Protocol):
    """Something that puts itself into a folder."""

    def to_files(self, folder: Path) -> None:
        """Write everything; the folder exists."""
        ...


def write_map(folder: Path, saved: Writes, snapshot: Snapshot, journey: Array) -> None:
    """All files of a map. Raises OSError."""
    inner = folder / FLOOR
    inner.mkdir()
    saved.to_files(inner)
    text, picture = nav2_map(snapshot.grid)
    write_atomic(folder / "map.yaml", text)
    write_atomic(folder / "map.pgm", picture)
    write_atomic(folder / "landmarks.csv", landmarks_csv(snapshot.landmarks))
    write_atomic(folder / "trajectory.tum", trajectory_tum(*laid_out(journey, snapshot.floor)))
    write_atomic(folder / PREVIEW, preview(snapshot.grid))


def known_part(grid: Grid) -> Grid:
    """A grid without the unknown cells around what is known. Raises ValueError when nothing is known."""
    rows, columns = (np.flatnonzero((grid.log_odds != 0).any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        raise ValueError("Nothing of this grid is known.")
    corner = np.array([columns[0], rows[0]])
    return Grid(
        revision=grid.revision,
        resolution=grid.resolution,
        origin=grid.origin + grid.resolution * corner,
        log_odds=grid.log_odds[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1],
    )


def preview(grid: Grid) -> bytes:
    """What is known of a grid as a small PNG; what is unknown is transparent."""
    picture = paint(known_part(grid))
    rows, columns = picture.shape[:2]
    scale = WIDEST / max(rows, columns)
    if scale < 1:
        size = (max(1, round(scale * columns)), max(1, round(scale * rows)))
        picture = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    return png(picture)


def png(picture: Array) -> bytes:
    """Picture (H, W, 4) uint8, red first → PNG."""
    _, packed = cv2.imencode(".png", cv2.cvtColor(picture, cv2.COLOR_RGBA2BGRA))
    return packed.tobytes()
