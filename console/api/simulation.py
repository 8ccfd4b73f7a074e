"""The simulated robot only: where it really is, and things and people put in its way."""

import asyncio
import base64
from typing import Annotated, Literal

import msgspec
from msgspec.structs import replace
from pydantic import Field

from console.access.roles import SOUND, needs
from console.api import Angle, Behind, HistoryInUse, OperatorLease, RequestBody, SimulatedRoom, Who, router
from console.speech.voice_commands import VoiceCommands
from core.errors import BadInput
from core.robots import requests
from core.speech.synthesis import PERSONS_VOICE, VoiceSettings, pcm, speak

MAX_PCM_CHARACTERS = 900_000  # characters of base64, 21 s at 16 kHz
PIECE_BYTES = 75_000  # of samples that go through the driver's pipe at once; an even number

simulation = router("simulation", 404, 409, 503)

Place = Annotated[list[Annotated[float, Field(ge=-1000, le=1000)]], Field(min_length=2, max_length=2)]  # x, y [m]
NOT_OBEYED = 'Voices in the room are not obeyed now, but for STOP; POST /api/hearing {"listen": true, "obey": true}.'


class PlaceRequest(RequestBody):
    """An object and its place in the world frame. `robot` carries the robot itself; its wheels do not notice.

    A person wears `clothes` ("red/blue": shirt and trousers), has a `gesture`, and with `path_m` walks from there
    along these places, `again` in a round.
    """

    what: Literal["person", "box", "robot"]
    x_m: float = Field(ge=-1000, le=1000)
    y_m: float = Field(ge=-1000, le=1000)
    heading_rad: Angle = 0.0
    id: str | None = Field(default=None, max_length=40)
    size_m: float | None = Field(default=None, ge=0, le=10)
    clothes: str | None = Field(default=None, max_length=40)
    gesture: str | None = Field(default=None, max_length=40)
    path_m: list[Place] | None = Field(default=None, min_length=1, max_length=100)
    speed_m_s: float | None = Field(default=None, ge=0, le=10)
    again: bool | None = None

    def request(self) -> requests.PlaceThing | requests.CarryRobot:
        if self.what == "robot":
            return requests.CarryRobot(x_m=self.x_m, y_m=self.y_m, heading_rad=self.heading_rad)
        return msgspec.convert(self.model_dump(), requests.PlaceThing)


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

    def request(self) -> requests.PlaceBoard:
        return msgspec.convert(self.model_dump(exclude={"what"}), requests.PlaceBoard)


class SayRequest(RequestBody):
    """Speech at a place in the simulated room: as `text`, or `pcm`, 16-bit samples of one channel in base64.

    Without a place, `id` names a person who stands in the room. With `more`, the next piece of the same `id` goes on.
    """

    text: str | None = Field(default=None, max_length=500)
    pcm: str | None = Field(default=None, max_length=MAX_PCM_CHARACTERS)
    rate_hz: int = Field(default=16_000, ge=8_000, le=48_000)
    x_m: Number | None = None
    y_m: Number | None = None
    z_m: Number | None = None
    id: str | None = Field(default=None, min_length=1, max_length=40)
    voice: str = Field(default=PERSONS_VOICE, max_length=40)
    speed: int = Field(default=150, ge=80, le=400)  # words a minute
    more: bool = False

    def request(self) -> requests.Speak:
        """The request to the driver, apart from the text. Raises BadInput for samples that are not in base64."""
        samples = None if self.pcm is None else samples_in(self.pcm)
        return requests.Speak(
            id=self.id, x_m=self.x_m, y_m=self.y_m, z_m=self.z_m, pcm=samples, rate_hz=self.rate_hz, more=self.more
        )


class RemoveRequest(RequestBody):
    """Which of the placed things goes."""

    id: str = Field(max_length=40)


@simulation.get("/sim/truth")
@needs("viewer")
async def truth(room: SimulatedRoom) -> requests.GroundTruth:
    """The true pose in the world frame. For scoring; no estimator sees it."""
    return await room(requests.ReadTruth())


@simulation.get("/sim/plan")
@needs("viewer")
async def plan(room: SimulatedRoom) -> requests.FloorPlan:
    """The true floor plan: walls as segments, and the things in the room."""
    return await room(requests.ReadPlan())


class PersonInRoom(msgspec.Struct, frozen=True):
    """A person in the simulated room, and where they really stand in the world frame."""

    id: str
    x_m: float
    y_m: float
    clothes: str


class PeopleInRoom(msgspec.Struct, frozen=True):
    """Everybody in the simulated room."""

    people: list[PersonInRoom]


@simulation.get("/sim/people")
@needs("viewer")
async def people_in_room(room: SimulatedRoom) -> PeopleInRoom:
    """List the people in the room and their places. For the page, on which they can be asked to speak; no estimator
    sees the list.
    """
    things = (await room(requests.ReadPlan())).things
    people = [thing for thing in things if isinstance(thing, requests.PlacedThing) and thing.what == "person"]
    return PeopleInRoom([PersonInRoom(one.id, one.x_m, one.y_m, one.clothes or "") for one in people])


@simulation.post("/sim/place", status_code=201)
@needs("operator")
async def place(
    asked: Annotated[PlaceRequest | PlaceBoardRequest, Field(discriminator="what")],
    room: SimulatedRoom,
    lease: OperatorLease,
    history: HistoryInUse,
    who: Who,
) -> requests.PlacedThing | requests.PlacedBoard | requests.GroundTruth:
    """Put a person or a box into the room, hold up a chessboard, or carry the robot."""
    if asked.what == "robot":
        lease.check_not_anothers(who)
    answer = await room(asked.request())
    history.add("place", who, words=asked.what)
    return answer


class SpokenInRoom(msgspec.Struct, frozen=True):
    """Whose mouth speaks, where, for how long, and whether the robot obeys voices in the room now."""

    id: str
    seconds: float
    x_m: float
    y_m: float
    obeyed: bool  # false: but for STOP the words are only shown, as `note` says
    note: str


@simulation.post("/sim/say", status_code=202)
@needs("operator", body=SOUND)
async def say(
    asked: SayRequest, room: SimulatedRoom, behind: Behind, history: HistoryInUse, who: Who
) -> SpokenInRoom:
    """A voice in the room: through its acoustics to the robot's microphones, and on as any voice."""
    request = asked.request()
    if asked.text is not None and request.pcm is None:
        chosen = VoiceSettings(voice=asked.voice, speed=asked.speed)
        sound = await asyncio.to_thread(speak, asked.text, chosen)  # not in the driver
        request = replace(request, pcm=pcm(sound), rate_hz=sound.rate)
    answer = await speak_in_pieces(room, request)
    history.add("say", who, words=asked.text or "")
    obeyed = behind.parts[VoiceCommands].operator is not None
    return SpokenInRoom(answer.id, answer.seconds, answer.x_m, answer.y_m, obeyed, "" if obeyed else NOT_OBEYED)


async def speak_in_pieces(room: requests.Ask, request: requests.Speak) -> requests.SpokenSound:
    """Let it sound, in pieces that go through the driver's pipe. Raises BadInput, Refused, Unavailable."""
    first, *rest = pieces(request)
    answer = await room(first)
    for piece in rest:
        answer = await room(replace(piece, id=answer.id))
    return answer


def pieces(request: requests.Speak) -> list[requests.Speak]:
    """Speech in pieces of samples; as it is where it has none."""
    samples = request.pcm
    if samples is None:
        return [request]
    begins = range(0, max(len(samples), 1), PIECE_BYTES)
    return [
        replace(
            request, pcm=samples[begin : begin + PIECE_BYTES], more=request.more or begin + PIECE_BYTES < len(samples)
        )
        for begin in begins
    ]


@simulation.post("/sim/remove")
@needs("operator")
async def remove(asked: RemoveRequest, room: SimulatedRoom, history: HistoryInUse, who: Who) -> requests.RemovedThing:
    """Take it away again."""
    answer = await room(requests.RemoveThing(id=asked.id))
    history.add("place", who, words="remove")
    return answer


def samples_in(text: str) -> bytes:
    """Base64 → samples. Raises BadInput."""
    try:
        return base64.b64decode(text, validate=True)
    except ValueError:
        raise BadInput("pcm must be 16-bit samples in base64.") from None
