"""The wizards' sessions: begin, show pictures, solve, accept, take away."""

import re
from typing import Annotated, Literal

import msgspec
from fastapi import Path, Query, Request, Response
from pydantic import Field

from console.access.roles import PICTURE, needs
from console.api import CalibrationSessions, HistoryInUse, Operator, RequestBody, Who, router
from console.api.typed_route import JsonAnswer, sends
from console.calibration.answers import SessionAnswer
from console.calibration.camera_worker import CameraWorker
from console.calibration.laser_worker import LaserWorker
from console.calibration.service import CalibrationService, SessionList, listed
from console.calibration.session import PICTURE_BUDGET_S, CalibrationSession
from console.calibration.session_worker import SessionWorker
from console.http.problems import Problem
from console.messages.calibration import (
    CalibrationBoard,
    CalibrationKind,
    CalibrationSessionState,
    CalibrationSource,
    CalibrationVerdict,
)
from console.workers.job import Job
from core.errors import BeckonError

calibration = router("calibration", 404, 409, 429, 503, 507)

MAX_FRAME_BYTES = 2_000_000  # of a webcam's picture
NAMELESS = "picture"
LONGEST_NAME = 80
PixelNumber = Annotated[float, Field(ge=-0.5, le=100_000, allow_inf_nan=False)]
Id = Annotated[str, Path(max_length=40)]
Name = Annotated[str, Path(max_length=200)]


class BoardRequest(RequestBody):
    """The chessboard, counted in inner corners."""

    columns: int = Field(ge=3, le=40)
    rows: int = Field(ge=3, le=40)
    square_m: float = Field(ge=0.001, le=1.0)
    panel_m: list[Annotated[float, Field(gt=0, le=5)]] | None = Field(default=None, min_length=2, max_length=2)


class SessionRequest(RequestBody):
    """`height_m`: of the camera above the laser by ruler, for boards that can only be held upright."""

    kind: CalibrationKind
    board: BoardRequest
    source: CalibrationSource = "robot"
    height_m: float | None = Field(default=None, ge=-2, le=2)


class LiveCaptureRequest(RequestBody):
    """`on`: look at the robot's own pictures."""

    on: bool


class AcceptRequest(RequestBody):
    """`force`: although it is not as exact as it should be."""

    force: bool = False


class CalibrationDocument(msgspec.Struct, frozen=True):
    """A calibration as its own file in JSON has it; `kind` in what was read from a file."""


@calibration.post("/calibration/sessions", status_code=201)
@needs("operator")
async def begin(
    asked: SessionRequest,
    calibration_service: CalibrationSessions,
    history: HistoryInUse,
    who: Who,
    response: Response,
) -> CalibrationSessionState:
    """Begin a session of a wizard."""
    panel = None if asked.board.panel_m is None else (asked.board.panel_m[0], asked.board.panel_m[1])
    board = CalibrationBoard(asked.board.columns, asked.board.rows, asked.board.square_m, panel)
    session = await calibration_service.begin(asked.kind, asked.source, board, asked.height_m)
    history.add("calibration", who, words=f"begin {asked.kind}")
    response.headers["Location"] = f"sessions/{session.card.id}"
    return session.shown


@calibration.get("/calibration/sessions")
@needs("viewer")
async def sessions(calibration_service: CalibrationSessions) -> SessionList:
    """All sessions, the newest first."""
    rows = [listed(session) for session in calibration_service.sessions.values()]
    return SessionList(sorted(rows, key=lambda row: -row.created_s))


@calibration.get("/calibration/sessions/{id}")
@needs("viewer")
async def one(id: Id, calibration_service: CalibrationSessions) -> CalibrationSessionState:
    """Everything about a session."""
    return calibration_service.find(id).shown


@calibration.delete("/calibration/sessions/{id}", status_code=204)
@needs("operator")
async def delete(id: Id, calibration_service: CalibrationSessions, history: HistoryInUse, who: Who) -> None:
    """Delete a session; a calibration accepted from it stays in use."""
    await calibration_service.delete(calibration_service.find(id))
    history.add("calibration", who, words="delete")


@calibration.post("/calibration/sessions/{id}/live")
@needs("operator")
async def live(
    id: Id, asked: LiveCaptureRequest, calibration_service: CalibrationSessions
) -> CalibrationSessionState:
    """Look at the robot's pictures and scans, and take good ones automatically."""
    session = calibration_service.find(id)
    calibration_service.live(session, on=asked.on)
    return session.shown


@calibration.post("/calibration/sessions/{id}/pictures")
@needs("operator", body=PICTURE)
@sends(CalibrationVerdict)
async def picture(
    id: Id,
    request: Request,
    calibration_service: CalibrationSessions,
    name: Annotated[str, Query(max_length=300)] = "",
    live: Annotated[Literal["0", "1"], Query()] = "0",
    stamp_s: Annotated[float, Query(ge=0, le=1e12, allow_inf_nan=False)] = 0.0,
    corners: Annotated[list[PixelNumber] | None, Query(min_length=8, max_length=8)] = None,
) -> Response:
    """A picture, as JPEG or PNG: sent on purpose, or with `live=1` a frame of the browser's webcam.

    `corners`: u, v [pixel] of its four extreme inner corners, eight times, where a person has marked them.
    """
    session = calibration_service.find(id)
    if session.card.kind != "camera":
        raise Problem(409, "The laser's session looks at the robot only; no pictures are sent to it.")
    content = await request.body()
    if live == "1":
        if len(content) > MAX_FRAME_BYTES:
            raise Problem(413, f"A webcam's picture may have {MAX_FRAME_BYTES} bytes; send it smaller.")
        job = CameraWorker.look_at_webcam(content, stamp_s)
        await session.act(job, budget=PICTURE_BUDGET_S, stamp=stamp_s, original=content)
    else:
        marked = corners or []
        await take(session, content, plain(name), list(zip(marked[::2], marked[1::2], strict=True)))
    return JsonAnswer(session.shown.verdict)


async def take(session: CalibrationSession, content: bytes, name: str, corners: list[tuple[float, float]]) -> None:
    """Raises BadInput with the fault of the picture, which the session shows as well."""
    try:
        await session.act(CameraWorker.take_upload(content, name, corners), budget=PICTURE_BUDGET_S, original=content)
    except BeckonError as wrong:
        session.trouble(f"{name}: {wrong}", "refused")
        raise


@calibration.post("/calibration/sessions/{id}/capture")
@needs("operator")
@sends(CalibrationVerdict)
async def capture(id: Id, calibration_service: CalibrationSessions) -> Response:
    """Take the robot's newest picture on purpose."""
    session = calibration_service.find(id)
    await calibration_service.capture(session)
    return JsonAnswer(session.shown.verdict)


@calibration.post("/calibration/sessions/{id}/views/{name}/drop")
@needs("operator")
async def drop(id: Id, name: Name, calibration_service: CalibrationSessions) -> CalibrationSessionState:
    """Leave a view out; the rest is solved again."""
    return await acted(calibration_service, id, SessionWorker.drop(name))


@calibration.post("/calibration/sessions/{id}/views/{name}/restore")
@needs("operator")
async def restore(id: Id, name: Name, calibration_service: CalibrationSessions) -> CalibrationSessionState:
    """Take a view back in."""
    return await acted(calibration_service, id, SessionWorker.restore(name))


@calibration.post("/calibration/sessions/{id}/skip")
@needs("operator")
async def skip(id: Id, calibration_service: CalibrationSessions) -> CalibrationSessionState:
    """Another suggestion, for one who cannot reach the present one."""
    return await acted(calibration_service, id, SessionWorker.skip())


@calibration.post("/calibration/sessions/{id}/background")
@needs("operator")
async def background(id: Id, calibration_service: CalibrationSessions) -> CalibrationSessionState:
    """Look at the empty room again."""
    if calibration_service.find(id).card.kind != "laser":
        raise Problem(409, "Only the laser's session looks at the empty room.")
    return await acted(calibration_service, id, LaserWorker.forget_room())


@calibration.post("/calibration/sessions/{id}/solve", status_code=202)
@needs("operator")
async def solve(id: Id, calibration_service: CalibrationSessions) -> CalibrationSessionState:
    """Solve in the background; how it goes stands in the session."""
    session = calibration_service.find(id)
    await session.solve_now()
    return session.shown


@calibration.post("/calibration/sessions/{id}/accept")
@needs("operator")
@sends(CalibrationDocument)
async def accept(
    id: Id, asked: AcceptRequest, calibration_service: CalibrationSessions, history: HistoryInUse, who: Operator
) -> Response:
    """Use this calibration from now on; the former can be taken back."""
    report = await calibration_service.accept(calibration_service.find(id), force=asked.force, who=who.name)
    history.add("calibration", who, words="accept")
    return JsonAnswer(report)


async def acted(sessions: CalibrationService, id: str, job: Job[SessionAnswer]) -> CalibrationSessionState:
    session = sessions.find(id)
    await session.act(job)
    return session.shown


def plain(name: str) -> str:
    """A file's name from a browser → one that stands well in a list and in an address."""
    last = re.split(r"[/\\]", name)[-1]
    return re.sub(r"[^\w.() +-]", "_", last).strip(" .")[:LONGEST_NAME] or NAMELESS
