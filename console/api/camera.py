"""The floor that the camera's picture shows."""

from typing import Annotated

import msgspec
from fastapi import Query

from console.access.roles import needs
from console.api import part, router
from console.control.picture_floor import PictureFloor
from core.errors import BadInput, Refused
from core.sentences import code_of

camera = router("state", 503)

Floor = Annotated[PictureFloor, part(PictureFloor)]
Pixel = Annotated[float, Query(ge=-0.5, le=20_000, allow_inf_nan=False)]
Stamp = Annotated[float, Query(ge=-1e12, le=1e12, allow_inf_nan=False)]


class PressedFloor(msgspec.Struct, frozen=True, kw_only=True):
    """The point of the floor that a pixel shows, in the world; without one, `why` says why."""

    x_m: float | None = None
    y_m: float | None = None
    distance_m: float | None = None  # from the robot, when the picture was taken
    ring_px: list[tuple[float, float]] = []  # around the point, as large as the robot: u, v in the picture
    why: str = ""
    code: str | None = None  # of the sentence in `why`, which keeps its meaning in every language
    values: dict[str, str] | None = None  # in that sentence, by their names


@camera.get("/camera/floor")
@needs("viewer")
async def floor(u_px: Pixel, v_px: Pixel, stamp_s: Stamp, floor: Floor) -> PressedFloor:
    """The point of the floor that a pixel shows, in the picture of that stamp: `stop at x and y` drives there.

    There is no point, and a sentence says why, above the horizon, where something that the laser sees stands before
    the floor, where a pixel is more than 0.3 m of it, in a picture older than two seconds, and while the camera's
    optics or its place on the robot are assumed.
    """
    try:
        (x, y), distance, ring = floor.floor(u_px, v_px, stamp_s)
    except (BadInput, Refused) as no_floor:
        return PressedFloor(why=str(no_floor), **code_of(str(no_floor))._asdict())
    return PressedFloor(
        x_m=round(x, 3),
        y_m=round(y, 3),
        distance_m=round(distance, 3),
        ring_px=[(u, v) for u, v in ring.round(1).tolist()],
    )
