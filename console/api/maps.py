"""Maps: the one in use to take away, and the saved ones to go on in."""

import asyncio
import io
import zipfile
from typing import Annotated

import cv2
import msgspec
import numpy as np
from fastapi import Path, Query, Request, Response
from pydantic import Field

from console.access.roles import ZIP_LIMIT, needs
from console.api import RequestBody, SavedMaps, Texts, Who, problems, router, sends_file
from console.http.downloads import file_named, zip_named
from console.maps.export import known_part
from console.maps.plan import LETTER_MM, plan_pdf, plan_svg
from console.maps.store import MAX_NAME_LETTERS, MapInfo, SavedMapFacts
from console.maps.trajectory import laid_out
from core.message import Array
from core.pipelines.nav2_map import map_pixels, nav2_map
from core.pipelines.slam_report import landmarks_csv, trajectory_tum
from core.slam.map.occupancy import OccupancyGrid

maps = router("map", 409, 429, 503, 507)

Name = Annotated[str, Path(min_length=1, max_length=4 * MAX_NAME_LETTERS)]
MatchId = Annotated[str, Path(max_length=20)]
LetterHeight = Annotated[float, Query(ge=2, le=30)]
NewName = Annotated[str, Query(min_length=1, max_length=4 * MAX_NAME_LETTERS)]


class SaveMapRequest(RequestBody):
    """Under which name; `replace`: also when there is a map of that name already."""

    name: str = Field(max_length=4 * MAX_NAME_LETTERS, examples=["ground floor"])
    replace: bool = False


class RenameMapRequest(RequestBody):
    """Another name for a saved map."""

    name: str = Field(max_length=4 * MAX_NAME_LETTERS, examples=["first floor"])


class SavedMapRow(SavedMapFacts, kw_only=True):
    """A saved map; `verified`: it bears checksums, which are compared when it is loaded or packed."""

    verified: bool


class TakenMap(SavedMapRow, kw_only=True):
    """A map that was taken in; `remark`: a sentence on what in its files may be meant otherwise, "" for none."""

    remark: str


class SavedMapList(msgspec.Struct, frozen=True):
    """All saved maps, the newest first, and the name of the one that the robot goes on in."""

    current: str | None  # None: a new map
    maps: list[SavedMapRow]


class MatchRequest(RequestBody):
    """Names of two saved maps of one building; the axes of the older one stay."""

    older: str = Field(max_length=4 * MAX_NAME_LETTERS)
    newer: str = Field(max_length=4 * MAX_NAME_LETTERS)


class JoinRequest(RequestBody):
    """A match that was looked at, and the name of the joined map."""

    match: str = Field(max_length=20)
    name: str = Field(max_length=4 * MAX_NAME_LETTERS)


class MapMatchRow(msgspec.Struct, frozen=True):
    """The place of the newer map in the older one: how many of its views `agree`, and what its walls lie on."""

    id: str
    older: str
    newer: str
    x_m: float
    y_m: float
    heading_rad: float
    agree: int
    of: int
    links: int
    overlap: float  # share of the newer map's walls, where both know the floor, that lie at walls of the older one
    conflict: float  # share that lies in the middle of its free floor


class LoadingMap(msgspec.Struct, frozen=True):
    """The name of the map that is being loaded."""

    loads: str | None


class MapOutlineRows(msgspec.Struct, frozen=True):
    """Polygons of the map: each ring x, y, x, y, … in centimetres, world frame."""

    walls_cm: list[list[int]]
    floor_cm: list[list[int]]


@maps.get("/map", **sends_file("application/zip"))
@needs("viewer")
async def nav2(maps: SavedMaps) -> Response:
    """YAML and PGM as Nav2's map server reads them, in a zip."""
    packed = await asyncio.to_thread(zipped, maps.grid)
    return file_named(packed, "map.zip", "application/zip")


@maps.get("/map.png", **sends_file("image/png"))
@needs("viewer")
async def picture(maps: SavedMaps) -> Response:
    """The mapped part as PNG: free 254, occupied 0, unknown 205.

    The headers tell a cell's size and the lower left corner in the world frame, in metres.
    """
    grid = maps.grid
    if grid.log_odds.any():
        grid = known_part(grid)
    packed = await asyncio.to_thread(lambda: cv2.imencode(".png", map_pixels(grid))[1].tobytes())
    x, y = (float(value) for value in grid.origin)
    frame = {"Map-Resolution-M": f"{grid.resolution:.9g}", "Map-Origin-M": f"{x:.6f}, {y:.6f}"}
    return Response(packed, media_type="image/png", headers=frame)


@maps.get("/map/outline")
@needs("viewer")
async def outline(maps: SavedMaps) -> MapOutlineRows:
    """Walls and free floor of the map as polygons, to be drawn at any scale; inner rings are holes."""
    traced = await asyncio.to_thread(lambda: maps.outline)
    return MapOutlineRows(rings_cm(traced.walls), rings_cm(traced.floor))


@maps.get("/map.svg", **sends_file("image/svg+xml"))
@needs("viewer")
async def svg(maps: SavedMaps, texts: Texts, letter_mm: LetterHeight = LETTER_MM) -> Response:
    """The map as a plan to print or to draw on: SVG in millimetres of an A4 sheet, with rooms and zones.

    `letter_mm`: the height of its words, larger where the sheet is shown small.
    """
    packed = await asyncio.to_thread(lambda: plan_svg(maps.plan_in(texts), letter_mm))
    return file_named(packed, f"{maps.shown.name or 'map'}.svg", "image/svg+xml")


@maps.get("/map.pdf", **sends_file("application/pdf"))
@needs("viewer")
async def pdf(maps: SavedMaps, texts: Texts) -> Response:
    """The map as a plan to print: PDF of one A4 sheet, all of it vectors."""
    packed = await asyncio.to_thread(lambda: plan_pdf(maps.plan_in(texts)))
    return file_named(packed, f"{maps.shown.name or 'map'}.pdf", "application/pdf")


@maps.get("/landmarks.csv", **sends_file("text/csv"))
@needs("viewer")
async def landmarks(maps: SavedMaps) -> Response:
    """The table of landmarks, one a line."""
    return file_named(landmarks_csv(maps.snapshot.landmarks).encode(), "landmarks.csv", "text/csv")


@maps.get("/trajectory.tum", **sends_file("text/plain"))
@needs("viewer")
async def trajectory(maps: SavedMaps) -> Response:
    """The robot's trajectory: `t tx ty tz qx qy qz qw` a line, as the submaps lie now, every tenth of a second."""
    rows, floor = maps.trajectory.rows(), maps.snapshot.floor
    text = await asyncio.to_thread(lambda: trajectory_tum(*laid_out(rows, floor)))
    return file_named(text.encode(), "trajectory.tum", "text/plain")


@maps.get("/maps")
@needs("viewer")
async def saved(maps: SavedMaps) -> SavedMapList:
    """Every saved map, the newest first, and the name of the one that the robot goes on in."""
    return SavedMapList(maps.shown.name, [map_row(card) for card in await maps.all()])


@maps.post("/maps", status_code=201)
@needs("operator")
async def save(asked: SaveMapRequest, maps: SavedMaps, who: Who) -> SavedMapRow:
    """Keep the map in use under a name."""
    return map_row(await maps.save(asked.name, who, replace=asked.replace))


@maps.post("/maps/import", status_code=201)
@needs("operator", body=ZIP_LIMIT)
async def take_in(request: Request, maps: SavedMaps, who: Who, name: NewName, replace: bool = False) -> TakenMap:
    """Keep a map under a name: one that another robot saved (its zip), or one of Nav2 or slam_toolbox: a zip of its
    YAML (trinary, scale or raw) and its PGM, PNG or BMP. Load it as any other; the robot finds its place in it.
    """
    card, remark = await maps.take_in(name, await request.body(), who, replace=replace)
    return TakenMap(**msgspec.structs.asdict(map_row(card)), remark=remark)


@maps.post("/maps/match", responses=problems(404))
@needs("operator")
async def match(asked: MatchRequest, maps: SavedMaps) -> MapMatchRow:
    """Find where one saved map lies in another. Look at it (`GET /api/maps/match/{id}.png`), then join."""
    shown = await maps.match(asked.older, asked.newer)
    found, pose = shown.found, shown.found.pose
    return MapMatchRow(
        shown.id,
        shown.older.card.name,
        shown.newer.card.name,
        round(pose.x, 4),
        round(pose.y, 4),
        round(pose.heading, 5),
        found.agree,
        found.searched,
        len(found.links),
        round(found.overlap, 3),
        round(found.conflict, 3),
    )


@maps.get("/maps/match/{id}.png", **sends_file("image/png"))
@needs("viewer")
async def match_picture(id: MatchId, maps: SavedMaps) -> Response:
    """Both maps over each other: the older one dark, the newer one red where they differ."""
    return Response(maps.proposal(id, 404).picture, media_type="image/png")


@maps.post("/maps/join", responses=problems(404), status_code=201)
@needs("operator")
async def join(asked: JoinRequest, maps: SavedMaps, who: Who) -> SavedMapRow:
    """Join the two maps of a match that was looked at, as a new saved map; both stay as they are."""
    return map_row(await maps.join(asked.match, asked.name, who))


@maps.post("/maps/{name}/load", status_code=202)
@needs("operator")
async def load(name: Name, maps: SavedMaps, who: Who) -> LoadingMap:
    """Go on in a saved map; the robot finds its place in it. Unsaved parts of the present map are lost."""
    await maps.load(name, who)
    return LoadingMap(maps.shown.name)


@maps.patch("/maps/{name}")
@needs("operator")
async def rename(name: Name, asked: RenameMapRequest, maps: SavedMaps, who: Who) -> SavedMapRow:
    """Rename a saved map; who goes on in it goes on in it. 409 where there is one of the new name."""
    return map_row(await maps.rename(name, asked.name, who))


@maps.delete("/maps/{name}", status_code=204)
@needs("operator")
async def delete(name: Name, maps: SavedMaps, who: Who) -> None:
    """Away with a saved map; who goes on in it keeps it in memory."""
    await maps.delete(name, who)


@maps.get("/maps/{name}.zip", **sends_file("application/zip"))
@needs("viewer")
async def packed(name: Name, maps: SavedMaps) -> Response:
    """Everything of a saved map: Nav2's YAML and PGM, landmarks, trajectory, and what Beckon goes on with."""
    kept = await maps.kept(name)
    return await zip_named(await maps.packed(name), f"{kept.card.name}.zip")


@maps.get("/maps/{name}.png", **sends_file("image/png"))
@needs("viewer")
async def preview(name: Name, maps: SavedMaps) -> Response:
    """A small picture of a saved map."""
    return Response(await maps.preview(name), media_type="image/png")


def zipped(grid: OccupancyGrid) -> bytes:
    """A grid as Nav2 reads it, in a zip."""
    text, picture = nav2_map(grid)
    return zip_of({"map.yaml": text.encode(), "map.pgm": picture})


def zip_of(files: dict[str, bytes]) -> bytes:
    """Files by their names → a zip."""
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as box:
        for name, content in files.items():
            box.writestr(name, content)
    return packed.getvalue()


def rings_cm(rings: tuple[Array, ...]) -> list[list[int]]:
    """Rings (N, 2) [m] → [x, y, x, y, …] each, in centimetres."""
    return [np.round(100 * ring).astype(int).ravel().tolist() for ring in rings]


def map_row(card: MapInfo) -> SavedMapRow:
    facts = {name: getattr(card, name) for name in SavedMapFacts.__struct_fields__}
    return SavedMapRow(**facts, verified=bool(card.files))
