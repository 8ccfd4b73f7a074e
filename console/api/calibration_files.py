"""Files of a calibration: pictures of views, exports in every form, what is in use, a board to print."""

import asyncio
from typing import IO, Annotated, Literal

import msgspec
from fastapi import Path, Query, Request, Response

from console.access.roles import TEXT, needs
from console.api import CalibrationSessions, HistoryInUse, Operator, RequestBody, RobotInUse, router, sends_file
from console.api.calibration import CalibrationDocument, Id, Name
from console.api.typed_route import JsonAnswer, sends
from console.calibration.answers import Document
from console.calibration.codec import camera_in
from console.calibration.session import PICTURE_BUDGET_S, CalibrationSession
from console.calibration.session_store import small_name
from console.calibration.solver_worker import SolverWorker
from console.http.downloads import file_named, zip_named
from console.http.problems import Problem
from console.messages.calibration import CalibrationKind
from core.calibration.board.board import Board
from core.calibration.board.printing import board_svg
from core.errors import Unwritable
from core.files import saving, text_of
from core.optics import CameraModel

calibration_files = router("calibration", 404, 409, 429, 503, 507)

Form = Annotated[str, Path(max_length=40)]
MEDIA = {"json": "application/json", "xml": "application/xml", "yaml": "application/yaml", "yml": "application/yaml"}


class UndoRequest(RequestBody):
    """Which of the two."""

    kind: CalibrationKind


class CalibrationDemoRequest(RequestBody):
    """`on`: the simulated person holds the board for this session."""

    session: str
    on: bool


class ActiveCalibrations(msgspec.Struct, frozen=True):
    """The accepted calibrations as their files have them; null: as built."""

    camera: Document | None
    laser: Document | None


class CalibrationDemo(msgspec.Struct, frozen=True):
    """State of the demonstration in which the simulated person shows how it goes: on or off."""

    demo: bool


@calibration_files.get("/calibration/sessions/{id}/views/{name}.jpg", **sends_file("image/jpeg"))
@needs("viewer")
async def view(
    id: Id,
    name: Name,
    calibration_service: CalibrationSessions,
    full: Annotated[Literal["0", "1"], Query()] = "0",
    corrected: Annotated[Literal["0", "1"], Query()] = "0",
) -> Response:
    """The picture of a view: small, or `full=1` in its own size, or `corrected=1` straight by the solution."""
    session = calibration_service.find(id)
    file = session.pictures.get(name)
    if file is None:
        raise Problem(404, "There is no picture of that view.")
    small = full == corrected == "0"
    if small:
        return Response(await read(session, small_name(file)), media_type="image/jpeg")
    camera = straightener(session) if corrected == "1" else None
    async with calibration_service.picture_turns.taken():
        job = SolverWorker.picture(await read(session, file), camera)
        picture = await calibration_service.solver.ask(job, budget=PICTURE_BUDGET_S)
    return Response(picture, media_type="image/jpeg")


@calibration_files.get(
    "/calibration/sessions/{id}/export/{form}", **sends_file("text/plain", "application/json", "application/zip")
)
@needs("viewer")
async def export(id: Id, form: Form, calibration_service: CalibrationSessions) -> Response:
    """A file: of a camera ros, opencv, kalibr, json; of a laser json, urdf, static_transform, matrix; of both all."""
    session = calibration_service.find(id)
    if form == "all":
        async with calibration_service.export_turns.taken():
            packed = await pack(session)
        return await zip_named(packed, f"calibration_{session.card.kind}.zip")
    if form not in session.exports:
        wanted = "Solve it first." if not session.exports else f"There are: {', '.join(session.exports)}, all."
        raise Problem(404, f"This session has no file of that form. {wanted}")
    name, text = session.exports[form]
    return file_named(text.encode(), name, MEDIA.get(name.rpartition(".")[2], "text/plain"))


@calibration_files.get("/calibration/in-use")
@needs("viewer")
async def active(calibration_service: CalibrationSessions) -> ActiveCalibrations:
    """The accepted calibrations; null: as built.

    Each with who accepted it when, why it is not used, or '', and whether there is a former one to take back.
    """
    return ActiveCalibrations(**calibration_service.used())


@calibration_files.post("/calibration/in-use/undo")
@needs("operator")
async def undo(
    asked: UndoRequest, calibration_service: CalibrationSessions, history: HistoryInUse, who: Operator
) -> ActiveCalibrations:
    """Take the former calibration back; where there is none, the nominal values are used."""
    await calibration_service.undo(asked.kind)
    history.add("calibration", who, words=f"undo {asked.kind}")
    return ActiveCalibrations(**calibration_service.used())


@calibration_files.post("/calibration/import")
@needs("operator", body=TEXT)
@sends(CalibrationDocument)
async def read_file(
    request: Request, calibration_service: CalibrationSessions, history: HistoryInUse, who: Operator
) -> Response:
    """Use what is in a file from now on: a camera (ROS camera_info, OpenCV, Kalibr, Beckon's own JSON) or a mount
    (static transform command, URDF joint, 4x4 matrices, Beckon's own JSON). `kind` in the answer tells which."""
    text = text_of(await request.body(), "The file")
    kind, report = await calibration_service.read(text, who.name)
    history.add("calibration", who, words=f"import {kind}")
    return JsonAnswer({"kind": kind, **report})


@calibration_files.get("/calibration/board.svg", **sends_file("image/svg+xml"))
@needs("viewer")
async def board(
    columns: Annotated[int, Query(ge=3, le=40)] = 9,
    rows: Annotated[int, Query(ge=3, le=40)] = 6,
    square_m: Annotated[float, Query(ge=0.001, le=1.0, allow_inf_nan=False)] = 0.025,
    page: Annotated[Literal["A4", "A3", "letter"], Query()] = "A4",
) -> Response:
    """A board to print, with rulers that show whether the printer kept the scale."""
    svg = board_svg(Board(columns=columns, rows=rows, square=square_m), page)
    return Response(svg, media_type="image/svg+xml")


@calibration_files.post("/calibration/demo")
@needs("operator")
async def show_demo(
    asked: CalibrationDemoRequest, robot: RobotInUse, calibration_service: CalibrationSessions
) -> CalibrationDemo:
    """The simulated person holds the board as advised until the session is ready."""
    if not robot.profile.simulated:
        raise Problem(404, "Only in the simulation can a simulated person show how it goes.")
    await calibration_service.show_demo(calibration_service.find(asked.session), on=asked.on)
    return CalibrationDemo(asked.on)


async def read(session: CalibrationSession, name: str) -> bytes:
    """A session's file. Raises Problem 404."""
    try:
        return await asyncio.to_thread(session.folder.read, name)
    except OSError:
        raise Problem(404, "The picture cannot be read any more.") from None


def straightener(session: CalibrationSession) -> CameraModel:
    """The camera by which a session's pictures are made straight. Raises Problem 409."""
    camera = session.card.camera or camera_in(session.shown)
    if camera is None:
        raise Problem(409, "Solve first; then pictures can be made straight.")
    return camera


async def pack(session: CalibrationSession) -> IO[bytes]:
    """A session as a zip on the disk. Raises Problem 404, Unwritable."""
    try:
        with saving("The session could not be packed"):
            return await asyncio.to_thread(session.folder.packed, dict(session.exports), dict(session.pictures))
    except Unwritable:
        if not session.folder.path.is_dir():
            raise Problem(404, "The session's files cannot be read any more.") from None
        raise
