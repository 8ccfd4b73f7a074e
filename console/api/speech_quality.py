"""Measured recognition of voices where the robot stands now: runs, their figures and their pages."""

import base64
import hashlib
import math
from typing import Annotated

import msgspec
from fastapi import Path, Response
from pydantic import Field

from console.access.roles import needs
from console.api import Behind, HistoryInUse, RequestBody, RobotInUse, Texts, Who, part, router, sends_file
from console.http.problems import Problem
from console.speech.quality_runs import QualityRuns, QualityRunState, QualitySetup
from core.robots.requests import ReadPlan, ReadTruth
from core.speech.quality.report import STYLE, in_language

speech_quality = router("speech quality", 409, 503, 507)
QualityTests = Annotated[QualityRuns, part(QualityRuns)]

Id = Annotated[str, Path(max_length=40)]
Distance = Annotated[float, Field(ge=0.3, le=12)]
Ratio = Annotated[float, Field(ge=-10, le=60)]
STYLED = base64.b64encode(hashlib.sha256(STYLE.encode()).digest()).decode()
POLICY = f"default-src 'none'; img-src data:; style-src 'sha256-{STYLED}'; frame-ancestors 'none'"
ONLY_SIMULATED = (
    "Hearing is measured by itself only on the simulated robot. With a real one, record what is said and what it "
    "hears, and compare them: beckon speech-quality --orig-wav ORIG.wav --rev-wav REV.wav"
)
DEFAULT_DISTANCES_M = (1.0, 2.0, 3.0)  # when nobody says anything else


class QualityRequest(RequestBody):
    """The places of speakers: `distances_m` from the robot, towards a place of the world or a direction of the robot;
    with a place and without distances at that place.

    `snr_db`: of a voice at 1 m over the room's noise. Every pair of both is measured with as many `phrases`.
    """

    distances_m: list[Distance] | None = Field(default=None, min_length=1, max_length=10)
    snr_db: list[Ratio] = Field(default=[30.0, 10.0], min_length=1, max_length=10)
    phrases: int = Field(default=18, ge=1, le=36)
    azimuth_rad: float = Field(default=0.0, ge=-10, le=10)
    x_m: float | None = Field(default=None, ge=-1000, le=1000)
    y_m: float | None = Field(default=None, ge=-1000, le=1000)


class QualityRunList(msgspec.Struct, frozen=True):
    """All runs, and why another one cannot begin."""

    runs: list[QualityRunState]  # newest first
    why_not: str


@speech_quality.get("/speech-quality")
@needs("viewer")
async def runs(robot: RobotInUse, quality: QualityTests) -> QualityRunList:
    """All runs, newest first; `why_not` says why another one cannot begin."""
    why_not = "" if robot.profile.simulated else ONLY_SIMULATED
    return QualityRunList([run.shown for run in reversed(quality.runs.values())], why_not)


@speech_quality.post("/speech-quality", status_code=202)
@needs("operator")
async def begin(
    asked: QualityRequest, behind: Behind, quality: QualityTests, history: HistoryInUse, who: Who
) -> QualityRunState:
    """Measure in the simulated room, from where the robot is now; how it goes stands in the run."""
    if not behind.robot.profile.simulated:
        raise Problem(409, ONLY_SIMULATED)
    robot = await behind.ask(ReadTruth())
    world = (await behind.ask(ReadPlan())).name
    towards, distances = robot.heading_rad + asked.azimuth_rad, list(DEFAULT_DISTANCES_M)
    if asked.x_m is not None and asked.y_m is not None:
        x, y = asked.x_m - robot.x_m, asked.y_m - robot.y_m
        towards, distances = math.atan2(y, x), [round(math.hypot(x, y), 2)]
    setup = QualitySetup(
        world=world,
        x_m=robot.x_m,
        y_m=robot.y_m,
        heading_rad=robot.heading_rad,
        towards_rad=towards,
        distances_m=asked.distances_m or distances,
        snr_db=asked.snr_db,
        phrases=asked.phrases,
    )
    run = quality.begin(setup, who)
    history.add("speech quality", who, words="begin")
    return run.shown


@speech_quality.get("/speech-quality/{id}")
@needs("viewer")
async def one(id: Id, quality: QualityTests) -> QualityRunState:
    """One run: how far it is, and a row of figures for every place."""
    return quality.find(id).shown


@speech_quality.post("/speech-quality/{id}/cancel")
@needs("operator")
async def cancel(id: Id, quality: QualityTests) -> QualityRunState:
    """Give it up; the results so far stay."""
    run = quality.find(id)
    await quality.cancel(run)
    return run.shown


@speech_quality.delete("/speech-quality/{id}", status_code=204)
@needs("operator")
async def delete(id: Id, quality: QualityTests) -> None:
    """Delete it for good."""
    await quality.delete(quality.find(id))


@speech_quality.get("/speech-quality/{id}/report/{row}", **sends_file("text/html"))
@needs("viewer")
async def report(id: Id, row: Annotated[int, Path(ge=0, le=100)], quality: QualityTests, texts: Texts) -> Response:
    """The page of one place: texts side by side, figures, spectrograms."""
    pages = quality.find(id).pages
    if row >= len(pages) or not pages[row]:
        raise Problem(404, "Nothing was measured there (yet).")
    return Response(
        in_language(pages[row], texts), media_type="text/html", headers={"Content-Security-Policy": POLICY}
    )
