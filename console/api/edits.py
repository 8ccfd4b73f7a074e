"""Edits of the map in use: made, taken back, made again."""

import math
from typing import Annotated, Literal

import msgspec
from pydantic import Field

from console.access.roles import BodyLimit, needs
from console.api import RequestBody, Who, part, problems, router
from console.api.zones import Corner
from console.maps.edits import MAX_BRUSH_M, MAX_EDIT_POINTS, EditService
from console.maps.marks import EditKind, EditMark

edits = router("map", 409, 503, 507)

Edits = Annotated[EditService, part(EditService)]
STROKE_BODY = BodyLimit(("application/json",), 131_072)


class EditRequest(RequestBody):
    """An edit: what becomes of the cells within `points_m`, or along them with a brush of `width_m`; `crop`: all
    outside of them is unknown; `turn`: the whole map by `angle_rad` about the origin of the world.
    """

    kind: Literal["free", "occupied", "unknown", "crop", "turn"]
    points_m: list[Corner] = Field(default=[], max_length=MAX_EDIT_POINTS)
    width_m: float = Field(default=0.0, ge=0, le=MAX_BRUSH_M)
    angle_rad: float = Field(default=0.0, ge=-math.pi, le=math.pi)


class EditChoice(RequestBody):
    """Which edit; null: the newest that can be."""

    id: int | None = Field(default=None, ge=1, le=2**53)


class VersionRequest(RequestBody):
    """The number of the edit after which the map was as it shall be; 0: before all edits."""

    version: int = Field(ge=0, le=2**53)


class EditRow(msgspec.Struct, frozen=True):
    """An edit of the map."""

    id: int
    kind: EditKind
    by: str
    at_s: float  # Unix time
    holds: bool  # False: it was taken back
    points: int
    width_m: float
    angle_rad: float


class EditList(msgspec.Struct, frozen=True):
    """All edits of the map in use, and the version of the map: the number of the last edit that holds."""

    edits: list[EditRow]
    version: int


def row_of(edit: EditMark) -> EditRow:
    """An edit, without its points."""
    return EditRow(
        edit.id, edit.kind, edit.by, edit.at_s, not edit.undone_s, len(edit.points_m), edit.width_m, edit.angle_rad
    )


def list_of(service: EditService) -> EditList:
    rows = [row_of(one) for one in service.edits]
    return EditList(rows, max((row.id for row in rows if row.holds), default=0))


@edits.get("/map/edits")
@needs("viewer")
async def listed(service: Edits) -> EditList:
    """The edits of the map in use, also those that were taken back."""
    return list_of(service)


@edits.post("/map/edits", status_code=201)
@needs("operator", body=STROKE_BODY)
async def add(asked: EditRequest, service: Edits, who: Who) -> EditRow:
    """Edit the map. What the robot saw, or will see, does not change it back."""
    points = [(x, y) for x, y in asked.points_m]
    return row_of(await service.add(asked.kind, points, asked.width_m, asked.angle_rad, who))


@edits.post("/map/edits/undo", responses=problems(404))
@needs("operator")
async def undo(asked: EditChoice, service: Edits, who: Who) -> EditList:
    """Take back an edit: the newest that holds, or the one that is named."""
    await service.undo(who, asked.id)
    return list_of(service)


@edits.post("/map/edits/redo", responses=problems(404))
@needs("operator")
async def redo(asked: EditChoice, service: Edits, who: Who) -> EditList:
    """Make an edit again that was taken back: the last one, or the one that is named."""
    await service.redo(who, asked.id)
    return list_of(service)


@edits.post("/map/edits/back")
@needs("operator")
async def back(asked: VersionRequest, service: Edits, who: Who) -> EditList:
    """Take back all edits after a version of the map."""
    await service.back_to(asked.version, who)
    return list_of(service)
