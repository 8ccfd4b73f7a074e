"""The occupancy map to take away."""

from __future__ import annotations

import io
import zipfile

import cv2
from fastapi import Response

from console.api import Behind, router
from console.problems import Problem
from console.roles import needs
from console.runtime import Runtime
from core.navigation.nav2_map import map_pixels, nav2_map
from core.slam.occupancy import Grid

maps = router("map")


@maps.get("/map", response_class=Response, responses={200: {"content": {"application/zip": {}}}})
@needs("viewer")
async def nav2(behind: Behind) -> Response:
    """YAML and PGM as Nav2's map server reads them, in a zip."""
    text, picture = nav2_map(grid_of(behind))
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as box:
        box.writestr("map.yaml", text)
        box.writestr("map.pgm", picture)
    headers = {"Content-Disposition": 'attachment; filename="map.zip"'}
    return Response(packed.getvalue(), media_type="application/zip", headers=headers)


@maps.get("/map.png", response_class=Response, responses={200: {"content": {"image/png": {}}}})
@needs("viewer")
async def png(behind: Behind) -> Response:
    """The same picture as PNG: free 254, occupied 0, unknown 205."""
    _, packed = cv2.imencode(".png", map_pixels(grid_of(behind)))
    return Response(packed.tobytes(), media_type="image/png")


def grid_of(behind: Runtime) -> Grid:
    """The map as it is now. Raises Problem 503 while there is none."""
    if behind.snapshot is None or behind.snapshot.grid.log_odds.size == 0:
        raise Problem(503, "There is no map yet; the robot is still looking around.")
    return behind.snapshot.grid
