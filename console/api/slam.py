"""Corrections of the map by an operator: wrong loop closures, and "I am here"."""

from __future__ import annotations

from typing import Annotated, Any

import msgspec
import numpy as np
from fastapi import Path
from pydantic import Field

from console.access.roles import needs
from console.api import Behind, RequestBody, Who, router
from console.messages.map import closure
from core.message import Array

slam = router("slam")

Number = Annotated[int, Path(ge=0, le=2**53)]


class RelocalizeRequest(RequestBody):
    """The robot's place in the world frame. Without a heading it finds it itself.

    `force`: also when it does not think that it is lost.
    """

    x_m: float = Field(ge=-1000, le=1000)
    y_m: float = Field(ge=-1000, le=1000)
    heading_rad: float | None = Field(default=None, ge=-100, le=100)
    force: bool = False


@slam.get("/slam/closures")
@needs("viewer")
async def closures(behind: Behind) -> dict[str, Any]:
    """Every place that was recognised, the oldest first."""
    return {"closures": [msgspec.to_builtins(closure(row)) for row in behind.maps.snapshot.floor.closures]}


@slam.post("/slam/closures/{number}/undo", status_code=202)
@needs("operator")
async def undo(number: Number, behind: Behind, who: Who) -> dict[str, Any]:
    """A closure does not hold: the rooms go back to where they would be without it."""
    behind.maps.undo(number, who)
    return {"closure": number, "becomes": "undone"}


@slam.post("/slam/closures/{number}/redo", status_code=202)
@needs("operator")
async def redo(number: Number, behind: Behind, who: Who) -> dict[str, Any]:
    """It holds after all."""
    behind.maps.redo(number, who)
    return {"closure": number, "becomes": "accepted"}


@slam.post("/slam/here", status_code=202)
@needs("operator")
async def here(asked: RelocalizeRequest, behind: Behind, who: Who) -> dict[str, Any]:
    """The robot is here. It looks around this place, and goes on when its scan agrees."""
    behind.maps.here(asked.x_m, asked.y_m, asked.heading_rad, who, force=asked.force)
    return {"x_m": asked.x_m, "y_m": asked.y_m, "heading_rad": asked.heading_rad}


@slam.get("/scan")
@needs("viewer")
async def scan(behind: Behind) -> dict[str, Any]:
    """The points that the newest scan of the laser hit, seen from the robot: x forward, y left."""
    snapshot = behind.maps.snapshot
    points: Array = snapshot.estimate.pose.inverse().apply(snapshot.scan_points)
    return {"stamp_s": snapshot.stamp, "points_m": np.round(points, 3).tolist()}
