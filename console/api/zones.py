"""Zones of the map in use: to keep out of, and slow ones."""

from typing import Annotated, Literal

import msgspec
from fastapi import Path, Query, Request, Response
from pydantic import Field

from console.access.roles import ZIP_LIMIT, needs
from console.api import RequestBody, Who, part, router, sends_file
from console.api.maps import NewName, zip_of
from console.http.downloads import file_named
from console.maps.marks import ZoneMark
from console.maps.store import MAX_NAME_LETTERS
from console.maps.zones import MAX_CORNERS, MaskReading, ZoneService
from core.navigation.zones import MapZone, ZoneKind

zones = router("places", 409, 503, 507)

Zones = Annotated[ZoneService, part(ZoneService)]
ZoneName = Annotated[str, Path(min_length=1, max_length=4 * MAX_NAME_LETTERS)]
Corner = Annotated[list[Annotated[float, Field(ge=-10_000, le=10_000)]], Field(min_length=2, max_length=2)]


class ZoneRequest(RequestBody):
    """A polygon of the map, its corners in metres; a slow one with the speed that holds in it."""

    name: str = Field(max_length=4 * MAX_NAME_LETTERS, examples=["stairs"])
    kind: Literal["keep_out", "slow"]
    points_m: list[Corner] = Field(min_length=3, max_length=MAX_CORNERS)
    max_speed_m_s: float | None = Field(default=None, ge=0, le=10)


class ZoneRow(msgspec.Struct, frozen=True):
    """A zone, where it is now."""

    name: str
    kind: ZoneKind
    points_m: list[tuple[float, float]]
    max_speed_m_s: float | None


class ZoneList(msgspec.Struct, frozen=True):
    """All zones of the map in use."""

    zones: list[ZoneRow]


class ZonesOfMask(msgspec.Struct, frozen=True):
    """The zones that were drawn of a mask; `left_out`: a sentence on cells that became none, "" for none."""

    zones: list[ZoneRow]
    left_out: str


def row_of(zone: MapZone) -> ZoneRow:
    """A zone, to a millimetre."""
    points = [(round(float(x), 3), round(float(y), 3)) for x, y in zone.points]
    return ZoneRow(zone.name, zone.kind, points, zone.max_speed)


@zones.get("/zones")
@needs("viewer")
async def listed(service: Zones) -> ZoneList:
    """The zones of the map in use."""
    return ZoneList([row_of(zone) for zone in service.zones])


@zones.post("/zones", status_code=201)
@needs("operator")
async def add(asked: ZoneRequest, service: Zones, who: Who) -> ZoneRow:
    """Draw a zone: no command enters one to keep out of; in a slow one the gate caps the speed, by hand too."""
    points = tuple((x, y) for x, y in asked.points_m)
    return row_of(await service.add(ZoneMark(asked.name, asked.kind, points, asked.max_speed_m_s), who))


@zones.get("/zones/masks", **sends_file("application/zip"))
@needs("viewer")
async def masks(service: Zones) -> Response:
    """All zones as Nav2's filter masks, in a zip: keep-out (trinary), speed in cm/s (raw), and Nav2's parameters."""
    return file_named(zip_of(await service.masks()), "masks.zip", "application/zip")


@zones.post("/zones/masks", status_code=201)
@needs("operator", body=ZIP_LIMIT)
async def take_in(
    request: Request,
    service: Zones,
    who: Who,
    name: NewName,
    kind: Literal["keep_out", "slow"],
    type: Annotated[int, Query(ge=1, le=2)] = 1,
    base: Annotated[float, Query(ge=-1000, le=1000)] = 100.0,
    multiplier: Annotated[float, Query(ge=-1000, le=1000)] = -1.0,
) -> ZonesOfMask:
    """Draw the zones of a filter mask of Nav2, a zip of its YAML and picture.

    Of a speed mask also `type` (1: % of the robot's largest speed, 2: m/s), `base` and `multiplier` of its filter
    info; a limit of 0 is none, as with Nav2.
    """
    reading = MaskReading(kind, 1 if type == 1 else 2, base, multiplier)
    drawn, left_out = await service.take_in(name, await request.body(), reading, who)
    return ZonesOfMask([row_of(zone) for zone in drawn], left_out)


@zones.delete("/zones/{name}", status_code=204)
@needs("operator")
async def remove(name: ZoneName, service: Zones, who: Who) -> None:
    """Remove a zone."""
    await service.remove(name, who)
