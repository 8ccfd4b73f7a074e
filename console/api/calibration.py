"""The wizards' sessions: begin, show pictures, solve, accept, take away."""

from __future__ import annotations

import re
from typing import Annotated, Any, Literal

from fastapi import Path, Query, Request, Response
from pydantic import Field

from console import wire
from console.api import Behind, Driver, Who, Wish, router
from console.calibration.sitting import PICTURE_BUDGET, Sitting
from console.calibration.workbench import listed
from console.problems import Problem
from console.roles import PICTURE, needs
from console.runtime import Runtime
from console.wire_calibration import CalibrationBoard, CalibrationKind, CalibrationSource
from core.errors import BeckonError

calibration = router("calibration")

LARGEST_FRAME = 2_000_000  # [bytes] of a webcam's picture
NAMELESS = "picture"
LONGEST_NAME = 80
PICTURES: dict[str, Any] = {
    "requestBody": {
        "required": True,
        "content": {kind: {"schema": {"type": "string", "format": "binary"}} for kind in ("image/jpeg", "image/png")},
    }
}

Id = Annotated[str, Path(max_length=40)]
Name = Annotated[str, Path(max_length=200)]


class BoardWish(Wish):
    """The chessboard, counted in inner corners."""

    columns: int = Field(ge=3, le=40)
    rows: int = Field(ge=3, le=40)
    square_m: float = Field(ge=0.001, le=1.0)
    panel_m: list[Annotated[float, Field(gt=0, le=5)]] | None = Field(default=None, min_length=2, max_length=2)


class SessionWish(Wish):
    """`height_m`: of the camera above the laser by ruler, for boards that can only be held upright."""

    kind: CalibrationKind
    board: BoardWish
    source: CalibrationSource = "robot"
    height_m: float | None = Field(default=None, ge=-2, le=2)


class LiveWish(Wish):
    """Whether to look at what the robot sees."""

    on: bool


class AcceptWish(Wish):
    """`anyway`: although it is not as exact as it should be."""

    anyway: bool = False


def told(sitting: Sitting, status: int = 200) -> Response:
    """A session as JSON."""
    return Response(wire.encode(sitting.session), status, media_type="application/json")


@calibration.post("/calibration/sessions", status_code=201)
@needs("operator")
async def begin(asked: SessionWish, behind: Behind, who: Who) -> Response:
    """Begin a session of a wizard."""
    panel = None if asked.board.panel_m is None else (asked.board.panel_m[0], asked.board.panel_m[1])
    board = CalibrationBoard(asked.board.columns, asked.board.rows, asked.board.square_m, panel)
    sitting = await behind.workbench.begin(asked.kind, asked.source, board, asked.height_m)
    behind.history.add("calibration", who, words=f"begin {asked.kind}")
    response = told(sitting, 201)
    response.headers["Location"] = f"sessions/{sitting.card.id}"
    return response


@calibration.get("/calibration/sessions")
@needs("viewer")
async def sessions(behind: Behind) -> dict[str, Any]:
    """All sessions, the newest first."""
    rows = [listed(sitting) for sitting in behind.workbench.sittings.values()]
    return {"sessions": sorted(rows, key=lambda row: -row["created_s"])}


@calibration.get("/calibration/sessions/{id}")
@needs("viewer")
async def one(id: Id, behind: Behind) -> Response:
    """Everything about a session."""
    return told(behind.workbench.find(id))


@calibration.delete("/calibration/sessions/{id}", status_code=204)
@needs("operator")
async def delete(id: Id, behind: Behind, who: Who) -> Response:
    """Delete a session; what was accepted from it stays in use."""
    await behind.workbench.delete(behind.workbench.find(id))
    behind.history.add("calibration", who, words="delete")
    return Response(status_code=204)


@calibration.post("/calibration/sessions/{id}/live")
@needs("operator")
async def live(id: Id, asked: LiveWish, behind: Behind) -> Response:
    """Look at the robot's pictures and scans, and take what is good by itself."""
    sitting = behind.workbench.find(id)
    behind.workbench.live(sitting, on=asked.on)
    return told(sitting)


@calibration.post("/calibration/sessions/{id}/pictures", openapi_extra=PICTURES)
@needs("operator", body=PICTURE)
async def picture(
    id: Id,
    request: Request,
    behind: Behind,
    name: Annotated[str, Query(max_length=300)] = "",
    live: Annotated[Literal["0", "1"], Query()] = "0",
    stamp_s: Annotated[float, Query(ge=0, le=1e12, allow_inf_nan=False)] = 0.0,
) -> Response:
    """A picture, as JPEG or PNG: sent on purpose, or with `live=1` a frame of the browser's webcam."""
    sitting = behind.workbench.find(id)
    if sitting.card.kind != "camera":
        raise Problem(409, "The laser's session looks at the robot only; no pictures are sent to it.")
    content = await request.body()
    if live == "1":
        if len(content) > LARGEST_FRAME:
            raise Problem(413, f"A webcam's picture may have {LARGEST_FRAME} bytes; send it smaller.")
        await sitting.act("frame", {"content": content, "stamp": stamp_s}, budget=PICTURE_BUDGET, stamp=stamp_s)
    else:
        await take(sitting, content, plain(name))
    return Response(wire.encode(sitting.session.verdict), media_type="application/json")


async def take(sitting: Sitting, content: bytes, name: str) -> None:
    """Raises BadInput with what is wrong with the picture, which the session shows as well."""
    try:
        await sitting.act("take", {"content": content, "name": name}, budget=PICTURE_BUDGET)
    except BeckonError as wrong:
        sitting.trouble(f"{name}: {wrong}", "refused")
        raise


@calibration.post("/calibration/sessions/{id}/capture")
@needs("operator")
async def capture(id: Id, behind: Behind) -> Response:
    """Take the robot's newest picture on purpose."""
    sitting = behind.workbench.find(id)
    await behind.workbench.capture(sitting)
    return Response(wire.encode(sitting.session.verdict), media_type="application/json")


@calibration.post("/calibration/sessions/{id}/views/{name}/drop")
@needs("operator")
async def drop(id: Id, name: Name, behind: Behind) -> Response:
    """Leave a view out; the rest is solved anew."""
    return await acted(behind, id, "drop", {"name": name})


@calibration.post("/calibration/sessions/{id}/views/{name}/restore")
@needs("operator")
async def restore(id: Id, name: Name, behind: Behind) -> Response:
    """Take a view back in."""
    return await acted(behind, id, "restore", {"name": name})


@calibration.post("/calibration/sessions/{id}/another")
@needs("operator")
async def another(id: Id, behind: Behind) -> Response:
    """Another suggestion, for one who cannot reach the present one."""
    return await acted(behind, id, "another", {})


@calibration.post("/calibration/sessions/{id}/background")
@needs("operator")
async def background(id: Id, behind: Behind) -> Response:
    """Look at the empty room anew."""
    if behind.workbench.find(id).card.kind != "laser":
        raise Problem(409, "Only the laser's session looks at the empty room.")
    return await acted(behind, id, "forget_room", {})


@calibration.post("/calibration/sessions/{id}/solve", status_code=202)
@needs("operator")
async def solve(id: Id, behind: Behind) -> Response:
    """Solve in the background; how it goes stands in the session."""
    sitting = behind.workbench.find(id)
    await sitting.solve_now()
    return told(sitting, 202)


@calibration.post("/calibration/sessions/{id}/accept")
@needs("operator")
async def accept(id: Id, asked: AcceptWish, behind: Behind, who: Driver) -> dict[str, Any]:
    """Use this calibration from now on; the former can be taken back."""
    report = await behind.workbench.accept(behind.workbench.find(id), anyway=asked.anyway, who=who.name)
    behind.history.add("calibration", who, words="accept")
    return report


async def acted(behind: Runtime, id: str, do: str, given: dict[str, Any]) -> Response:
    """Do something at the desk and show the session as it is then."""
    sitting = behind.workbench.find(id)
    await sitting.act(do, given)
    return told(sitting)


def plain(name: str) -> str:
    """A file's name from a browser → one that stands well in a list and in an address."""
    last = re.split(r"[/\\]", name)[-1]
    return re.sub(r"[^\w.() +-]", "_", last).strip(" .")[:LONGEST_NAME] or NAMELESS
