"""The simulated robot only: where it really is, and things and people put in its way."""

from __future__ import annotations

import asyncio
import base64
from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Field

from console.access.roles import SOUND, needs
from console.api import Behind, RequestBody, Who, router
from console.http.problems import Problem
from console.runtime import Runtime
from core.speech.synthesis import PERSONS_VOICE, VoiceSettings, pcm, speak

PCM = 900_000  # characters of base64, 21 s at 16 kHz
PIECE = 100_000  # of them that go through the driver's pipe at once; a multiple of 4

simulation = router("simulation")


Place = Annotated[list[Annotated[float, Field(ge=-1000, le=1000)]], Field(min_length=2, max_length=2)]  # x, y [m]


class PlaceRequest(RequestBody):
    """An object and its place in the world frame. `robot` carries the robot itself; its wheels do not notice.

    A person wears `clothes` ("red/blue": shirt and trousers), has a `gesture`, and with `path_m` walks from there
    along these places, `again` in a round.
    """

    what: Literal["person", "box", "robot"]
    x_m: float = Field(ge=-1000, le=1000)
    y_m: float = Field(ge=-1000, le=1000)
    heading_rad: float = Field(default=0.0, ge=-100, le=100)
    id: str | None = Field(default=None, max_length=40)
    size_m: float | None = Field(default=None, ge=0, le=10)
    clothes: str | None = Field(default=None, max_length=40)
    gesture: str | None = Field(default=None, max_length=40)
    path_m: list[Place] | None = Field(default=None, min_length=1, max_length=100)
    speed_m_s: float | None = Field(default=None, ge=0, le=10)
    again: bool | None = None


Number = Annotated[float, Field(ge=-1000, le=1000)]  # [m] or a part of a rotation


class BoardInCameraRequest(RequestBody):
    """A board's pose in the camera's frame, P_camera = rotation · P_board + translation, as the advice has it."""

    rotation: list[list[Number]] = Field(min_length=3, max_length=3)
    translation_m: list[Number] = Field(min_length=3, max_length=3)


class PlaceBoardRequest(RequestBody):
    """A chessboard that is held up: its middle and axes in the world frame, or its pose in the camera's frame.

    Where there is one already, it is moved there in `seconds`. With `holder`, a person stands behind it.
    """

    what: Literal["board"]
    columns: int = Field(default=9, ge=3, le=40)
    rows: int = Field(default=6, ge=3, le=40)
    square_m: float = Field(default=0.03, ge=0.001, le=1)
    panel_m: list[Number] | None = Field(default=None, min_length=2, max_length=2)
    x_m: Number | None = None
    y_m: Number | None = None
    z_m: Number | None = None
    rotation: list[list[Number]] | None = Field(default=None, min_length=3, max_length=3)
    in_camera: BoardInCameraRequest | None = None
    seconds: float = Field(default=0.0, ge=0, le=10)
    holder: bool = False


class SayRequest(RequestBody):
    """Speech at a place in the simulated room: as `text`, or `pcm`, 16-bit samples of one channel in base64.

    Without a place, `id` names a person who stands in the room. With `more`, the next piece of the same `id` goes on.
    """

    text: str | None = Field(default=None, max_length=500)
    pcm: str | None = Field(default=None, max_length=PCM)
    rate_hz: int = Field(default=16_000, ge=8_000, le=48_000)
    x_m: Number | None = None
    y_m: Number | None = None
    z_m: Number | None = None
    id: str | None = Field(default=None, min_length=1, max_length=40)
    voice: str = Field(default=PERSONS_VOICE, max_length=40)
    speed: int = Field(default=150, ge=80, le=400)  # words a minute
    more: bool = False


class RemoveRequest(RequestBody):
    """Which of the placed things goes."""

    id: str = Field(max_length=40)


@simulation.get("/sim/truth")
@needs("viewer")
async def truth(behind: Behind) -> dict[str, Any]:
    """The true pose in the world frame. For scoring; no estimator sees it."""
    return await simulated(behind).ask({"do": "truth"})


@simulation.get("/sim/plan")
@needs("viewer")
async def plan(behind: Behind) -> dict[str, Any]:
    """The true floor plan: walls as segments, and the things in the room."""
    return await simulated(behind).ask({"do": "plan"})


@simulation.post("/sim/place", status_code=201)
@needs("operator")
async def place(
    asked: Annotated[PlaceRequest | PlaceBoardRequest, Field(discriminator="what")], behind: Behind, who: Who
) -> dict[str, Any]:
    """Put a person or a box into the room, hold up a chessboard, or carry the robot."""
    if asked.what == "robot":
        behind.lease.check_not_anothers(who)
    wanted = {key: value for key, value in asked.model_dump().items() if value is not None}
    answer = await simulated(behind).ask({"do": "place", **wanted})
    behind.history.add("place", who, words=asked.what)
    return answer


@simulation.post("/sim/say", status_code=202)
@needs("operator", body=SOUND)
async def say(asked: SayRequest, behind: Behind, who: Who) -> dict[str, Any]:
    """A voice in the room: through its acoustics to the robot's microphones, and on as any voice."""
    wanted = {key: value for key, value in asked.model_dump().items() if value is not None}
    simulated(behind)
    if asked.text is not None and asked.pcm is None:
        chosen = VoiceSettings(voice=asked.voice, speed=asked.speed)
        sound = await asyncio.to_thread(speak, asked.text, chosen)  # not in the driver
        wanted |= {"pcm": base64.b64encode(pcm(sound)).decode(), "rate_hz": sound.rate}
    answer: dict[str, Any] = {}
    for piece in pieces(wanted):
        answer = await behind.ask({"do": "say", **piece, **({"id": answer["id"]} if answer else {})})
    behind.history.add("say", who, words=asked.text or "")
    return answer


def pieces(wanted: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """A wish to say something, in pieces that go through the driver's pipe."""
    if "pcm" not in wanted:
        yield wanted
        return
    samples = str(wanted["pcm"])
    for begin in range(0, max(len(samples), 1), PIECE):
        more = wanted.get("more", False) or begin + PIECE < len(samples)
        yield wanted | {"pcm": samples[begin : begin + PIECE], "more": more}


@simulation.post("/sim/remove")
@needs("operator")
async def remove(asked: RemoveRequest, behind: Behind, who: Who) -> dict[str, Any]:
    """Take it away again."""
    answer = await simulated(behind).ask({"do": "remove", "id": asked.id})
    behind.history.add("place", who, words="remove")
    return answer


def simulated(behind: Runtime) -> Runtime:
    """Raises Problem 404 for a robot that is not simulated."""
    if behind.robot.profile.kind != "SIM":
        raise Problem(404, "This robot is not simulated.")
    return behind
