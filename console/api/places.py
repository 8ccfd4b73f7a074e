"""Named places of the map in use."""

from typing import Annotated

import msgspec
from fastapi import Path
from pydantic import Field

from console.access.roles import needs
from console.api import Angle, RequestBody, Who, part, router
from console.maps.places import MAX_ROOM_CORNERS, PlaceService
from core.errors import BadInput
from core.navigation.places import NamedPlace
from core.sentences import Statement
from core.speech.understanding.place_names import MAX_NAME_LETTERS

places = router("places", 409, 503, 507)

MAX_COORDINATE_M = 10_000.0

Places = Annotated[PlaceService, part(PlaceService)]
PlaceName = Annotated[str, Path(min_length=1, max_length=2 * MAX_NAME_LETTERS)]
Coordinate = Annotated[float | None, Field(ge=-MAX_COORDINATE_M, le=MAX_COORDINATE_M)]
RoomCorner = Annotated[
    list[Annotated[float, Field(ge=-MAX_COORDINATE_M, le=MAX_COORDINATE_M)]], Field(min_length=2, max_length=2)
]


class NamePlaceRequest(RequestBody):
    """A name, and where; without `x_m` and `y_m` where the robot is now. `heading_rad`: to look there in the end.

    A room has its corners as `outline_m`; the robot goes where there is most room in it.
    """

    name: str = Field(max_length=2 * MAX_NAME_LETTERS, examples=["kitchen"])
    x_m: Coordinate = None
    y_m: Coordinate = None
    heading_rad: Angle | None = None
    outline_m: list[RoomCorner] = Field(default=[], max_length=MAX_ROOM_CORNERS)


class PlaceChange(RequestBody):
    """The fields that change; `heading_rad` null: any heading will do."""

    name: str | None = Field(default=None, max_length=2 * MAX_NAME_LETTERS)
    x_m: Coordinate = None
    y_m: Coordinate = None
    heading_rad: Angle | None = None


class PlaceRow(msgspec.Struct, frozen=True):
    """A named place, where it is now."""

    name: str
    x_m: float
    y_m: float
    heading_rad: float | None
    outline_m: list[tuple[float, float]] = []  # corners of a room
    wall_m: float | None = None  # to the nearest wall, where it was named or moved just now and one is near


class PlaceList(msgspec.Struct, frozen=True):
    """All places of the map in use."""

    places: list[PlaceRow]


def row_of(place: NamedPlace, wall: float | None = None) -> PlaceRow:
    """A place, to a millimetre; `wall` [m]: distance to the nearest one."""
    heading = None if place.heading_rad is None else round(place.heading_rad, 4)
    outline = [(round(x, 3), round(y, 3)) for x, y in place.outline_m]
    return PlaceRow(place.name, round(place.x_m, 3), round(place.y_m, 3), heading, outline, wall)


@places.get("/places")
@needs("viewer")
async def listed(service: Places) -> PlaceList:
    """The named places of the map in use. Each is understood in "go to NAME" and "stop at NAME"."""
    return PlaceList([row_of(one) for one in service.places])


@places.post("/places", status_code=201)
@needs("operator")
async def add(asked: NamePlaceRequest, service: Places, who: Who) -> PlaceRow:
    """Name a place. A name that sounds like a command, a number or another place is refused with the pair."""
    outline = tuple((x, y) for x, y in asked.outline_m)
    place = await service.add(asked.name, _at(asked), asked.heading_rad, who, outline)
    return row_of(place, service.wall_near(place))


@places.patch("/places/{name}")
@needs("operator")
async def change(name: PlaceName, asked: PlaceChange, service: Places, who: Who) -> PlaceRow:
    """Rename or move a place."""
    turned = "heading_rad" in asked.model_fields_set
    place = await service.change(
        name, who, to_name=asked.name, at=_at(asked), heading=asked.heading_rad, turned=turned
    )
    return row_of(place, service.wall_near(place))


@places.delete("/places/{name}", status_code=204)
@needs("operator")
async def remove(name: PlaceName, service: Places, who: Who) -> None:
    """Forget a place."""
    await service.remove(name, who)


def _at(asked: NamePlaceRequest | PlaceChange) -> tuple[float, float] | None:
    """The spot that was asked for; None where no coordinate was. Raises BadInput where one was."""
    if asked.x_m is None and asked.y_m is None:
        return None
    if asked.x_m is None or asked.y_m is None:
        raise BadInput(Statement("places.half"))
    return asked.x_m, asked.y_m
