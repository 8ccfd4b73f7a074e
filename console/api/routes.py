"""Routes of the map in use, and the one under way."""

import asyncio
import contextlib
from typing import Annotated, Literal

import msgspec
from fastapi import Path, Response
from pydantic import Field

from console.access.roles import needs
from console.api import RequestBody, Who, part, problems, router, sends_file
from console.http.problems import Problem
from console.maps.marks import RouteMark
from console.maps.routes import MAX_SAID_LETTERS, MAX_STOPS, MAX_WAIT_S, RouteNote, RouteRun, RouteService, RouteState
from console.maps.store import MAX_NAME_LETTERS as MAX_ROUTE_LETTERS
from console.messages import filled
from core.sentences import Statement
from core.speech.understanding.place_names import MAX_NAME_LETTERS

routes = router("places", 409, 503, 507)

Routes = Annotated[RouteService, part(RouteService)]
MAX_EVERY_MIN = 1440.0
PictureName = Annotated[str, Path(pattern=r"^[a-z0-9-]{1,100}\.jpg$")]
RouteName = Annotated[str, Path(min_length=1, max_length=4 * MAX_ROUTE_LETTERS)]


class StopRequest(RequestBody):
    """A stop: a named place, what is done there, and a wait."""

    place: str = Field(max_length=2 * MAX_NAME_LETTERS)
    wait_s: float = Field(default=0.0, ge=0, le=MAX_WAIT_S)
    action: Literal["wait_for_continue", "come_here", "say", "take_a_picture", "record"] | None = None
    text: str = Field(default="", max_length=MAX_SAID_LETTERS)


class RouteRequest(RequestBody):
    """Places in an order; `loop`: round and round, until a person ends it. `replace`: a route of that name, too.

    Rounds of a loop begin between `begins` and `ends` ("HH:MM", the console's clock), `every_min` minutes at least
    from one beginning to the next.
    """

    name: str = Field(max_length=4 * MAX_ROUTE_LETTERS, examples=["evening round"])
    stops: list[StopRequest] = Field(min_length=1, max_length=MAX_STOPS)
    loop: bool = False
    begins: str = Field(default="", max_length=5, examples=["08:30"])
    ends: str = Field(default="", max_length=5, examples=["17:00"])
    every_min: float = Field(default=0.0, ge=0, le=MAX_EVERY_MIN)
    replace: bool = False


class StartRequest(RequestBody):
    """`unattended`: the route goes on without a sign of life of who started it."""

    unattended: bool = False


class RouteList(msgspec.Struct, frozen=True):
    """All routes of the map in use."""

    routes: tuple[RouteMark, ...]


class RouteProgress(msgspec.Struct, frozen=True):
    """The route under way, or the last one."""

    name: str | None  # None: none ran yet
    stop: int  # that is driven to or stood at, counted from 1; 0: none
    of: int
    state: RouteState
    reason: str  # a sentence: why it stands, or ended
    round: int = 0  # full rounds so far
    place: str = ""
    owner: str = ""
    skipped: int = 0
    notes: list[RouteNote] = []  # what happened at each stop, the newest last


def progress_of(run: RouteRun | None) -> RouteProgress:
    if run is None:
        return RouteProgress(None, 0, 0, "idle", "")
    own = {"name": run.route.name, "stop": run.stop + 1, "of": len(run.route.stops), "round": run.rounds}
    return filled(RouteProgress, run, **own, place=run.here.place, owner=run.owner.name)


@routes.get("/routes")
@needs("viewer")
async def listed(service: Routes) -> RouteList:
    """The routes of the map in use."""
    return RouteList(service.routes)


@routes.post("/routes", responses=problems(404), status_code=201)
@needs("operator")
async def add(asked: RouteRequest, service: Routes, who: Who) -> RouteMark:
    """Keep a route. A stop without a place of that name is refused."""
    return await service.add(msgspec.convert(asked, RouteMark, from_attributes=True), who, replace=asked.replace)


@routes.delete("/routes/{name}", status_code=204)
@needs("operator")
async def remove(name: RouteName, service: Routes, who: Who) -> None:
    """Remove a route; one that runs goes on with its own copy."""
    await service.remove(name, who)


@routes.post("/routes/{name}/start", status_code=202)
@needs("operator")
async def start(name: RouteName, service: Routes, who: Who, asked: StartRequest | None = None) -> RouteProgress:
    """Start a route in this person's name. It pauses when their control ends, unless it is `unattended`."""
    return progress_of(service.start(name, who, unattended=asked is not None and asked.unattended))


@routes.get("/route")
@needs("viewer")
async def progress(service: Routes) -> RouteProgress:
    """How the route under way goes, or how the last one ended."""
    return progress_of(service.run_now)


class PictureList(msgspec.Struct, frozen=True):
    """Names of the pictures that were taken at stops, the newest first."""

    pictures: list[str]


@routes.get("/route/pictures")
@needs("viewer")
async def pictures(service: Routes) -> PictureList:
    """The pictures that were taken at stops; each has route, stop, pose and time in its comment."""

    def newest_first() -> list[str]:
        dated: list[tuple[float, str]] = []
        for path in service.pictures.glob("*.jpg"):
            with contextlib.suppress(FileNotFoundError):  # it was removed meanwhile
                dated.append((path.stat().st_mtime, path.name))
        return [name for _, name in sorted(dated, reverse=True)]

    return PictureList(await asyncio.to_thread(newest_first))


@routes.get("/route/pictures/{name}", **sends_file("image/jpeg", errors=[404]))
@needs("viewer")
async def picture(name: PictureName, service: Routes) -> Response:
    """A picture that was taken at a stop."""
    try:
        return Response(await asyncio.to_thread((service.pictures / name).read_bytes), media_type="image/jpeg")
    except OSError:
        raise Problem(404, Statement("routes.picture_gone")) from None


@routes.post("/route/pause")
@needs("operator")
async def pause(service: Routes, who: Who) -> RouteProgress:
    """Stand, and wait for resume."""
    return progress_of(service.pause(who))


@routes.post("/route/resume")
@needs("operator")
async def resume(service: Routes, who: Who) -> RouteProgress:
    """Go on at the stop where it stands, in this person's name; also the answer to “wait for continue”."""
    return progress_of(service.resume(who))


@routes.post("/route/skip")
@needs("operator")
async def skip(service: Routes, who: Who) -> RouteProgress:
    """Leave out the stop that is driven to or stood at."""
    return progress_of(service.skip(who))


@routes.post("/route/stop")
@needs("viewer")
async def stop(service: Routes, who: Who) -> RouteProgress:
    """End the route; the robot stands. Anybody who is signed in may."""
    return progress_of(service.stop(who))
