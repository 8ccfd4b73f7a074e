"""Corrections of the map by an operator: wrong loop closures, and "I am here"."""

from typing import Annotated, Literal

import msgspec
import numpy as np
from fastapi import Path
from pydantic import Field

from console.access.roles import needs
from console.api import Angle, RequestBody, SavedMaps, Who, router
from console.messages.map import ClosureRow, closure
from core.message import Array

slam = router("slam", 409, 503)

Number = Annotated[int, Path(ge=0, le=2**53)]


class RelocalizeRequest(RequestBody):
    """The robot's place in the world frame. Without a heading it finds it itself.

    `force`: also when it does not think that it is lost.
    """

    x_m: float = Field(ge=-1000, le=1000)
    y_m: float = Field(ge=-1000, le=1000)
    heading_rad: Angle | None = None
    force: bool = False


class ClosureList(msgspec.Struct, frozen=True):
    """Every place that was recognised, the oldest first."""

    closures: list[ClosureRow]


class ClosureChange(msgspec.Struct, frozen=True):
    """New state of a closure."""

    closure: int
    becomes: Literal["undone", "accepted"]


class ClaimedPlace(msgspec.Struct, frozen=True):
    """The robot's place by the operator."""

    x_m: float
    y_m: float
    heading_rad: float | None


class LaserPoints(msgspec.Struct, frozen=True):
    """A scan, seen from the robot."""

    stamp_s: float
    points_m: list[tuple[float, float]]  # x forward, y left


@slam.get("/slam/closures")
@needs("viewer")
async def closures(maps: SavedMaps) -> ClosureList:
    """Every place that was recognised, the oldest first."""
    return ClosureList([closure(row) for row in maps.snapshot.floor.closures])


@slam.post("/slam/closures/{number}/undo", status_code=202)
@needs("operator")
async def undo(number: Number, maps: SavedMaps, who: Who) -> ClosureChange:
    """A closure does not hold: the rooms go back to where they would be without it."""
    maps.change_closure(number, "undo", who)
    return ClosureChange(number, "undone")


@slam.post("/slam/closures/{number}/redo", status_code=202)
@needs("operator")
async def redo(number: Number, maps: SavedMaps, who: Who) -> ClosureChange:
    """It holds after all."""
    maps.change_closure(number, "redo", who)
    return ClosureChange(number, "accepted")


@slam.post("/slam/here", status_code=202)
@needs("operator")
async def here(asked: RelocalizeRequest, maps: SavedMaps, who: Who) -> ClaimedPlace:
    """The robot is here. It looks around this place, and goes on when its scan agrees."""
    maps.here(asked.x_m, asked.y_m, asked.heading_rad, who, force=asked.force)
    return ClaimedPlace(asked.x_m, asked.y_m, asked.heading_rad)


@slam.get("/scan")
@needs("viewer")
async def scan(maps: SavedMaps) -> LaserPoints:
    """The points that the newest scan of the laser hit, seen from the robot: x forward, y left."""
    snapshot = maps.snapshot
    points: Array = snapshot.estimate.pose.inverse().apply(snapshot.scan_points)
    return LaserPoints(snapshot.stamp, [(x, y) for x, y in np.round(points, 3).tolist()])
