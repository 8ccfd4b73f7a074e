"""Requests to a robot's driver and their answers: frozen, typed, and checked where they arrive.

Every kind of robot lists the requests that it takes in `Robot.requests`; those of a kind that is not in this file are
declared beside it. Keys carry their units; places are in the world frame.
"""

import math
from typing import Any, Generic, Literal, Protocol, TypeVar, get_args

import msgspec

from core.errors import BadInput

AnswerT = TypeVar("AnswerT", bound=msgspec.Struct)
AnswerT_co = TypeVar("AnswerT_co", bound=msgspec.Struct, covariant=True)

Point = tuple[float, float]  # x, y [m]


class RobotRequest(
    msgspec.Struct, Generic[AnswerT_co], frozen=True, kw_only=True, tag_field="do", forbid_unknown_fields=True
):
    """Base of all requests to a driver; `AnswerT_co` is the struct of the answer."""


# the simulated robot


class GroundTruth(msgspec.Struct, frozen=True):
    """True pose of the simulated robot."""

    x_m: float
    y_m: float
    heading_rad: float
    stamp_s: float
    clearance_m: float  # between its body and the nearest wall or thing
    contact: bool


class PlacedThing(msgspec.Struct, frozen=True, kw_only=True, tag_field="kind", tag="thing"):
    """A thing or a person in the room. Only a person has clothes and a gesture, and only one who walks a path."""

    id: str
    what: str
    x_m: float
    y_m: float
    heading_rad: float
    length_m: float
    depth_m: float
    height_m: float
    fixed: bool  # it belongs to the room and cannot be removed
    clothes: str | msgspec.UnsetType = msgspec.UNSET
    gesture: str | msgspec.UnsetType = msgspec.UNSET
    path_m: tuple[Point, ...] | msgspec.UnsetType = msgspec.UNSET
    speed_m_s: float | msgspec.UnsetType = msgspec.UNSET
    again: bool | msgspec.UnsetType = msgspec.UNSET


class PlacedBoard(msgspec.Struct, frozen=True, kw_only=True, tag_field="kind", tag="board"):
    """The chessboard that is held up: its middle, its axes as columns of `rotation`, and its outline."""

    id: str
    what: Literal["board"] = "board"
    x_m: float
    y_m: float
    z_m: float
    columns: int
    rows: int
    square_m: float
    panel_m: tuple[float, float]  # width, height
    rotation: tuple[tuple[float, ...], ...]  # 3 rows, world from board
    outline_m: tuple[tuple[float, ...], ...]  # corners of the panel (x, y, z)
    holder: str | None  # id of the person who holds it
    fixed: bool = False
    seconds: float | msgspec.UnsetType = msgspec.UNSET  # [s] of the way there, in the answer to `PlaceBoard`


class FloorPlan(msgspec.Struct, frozen=True):
    """The true floor plan as the laser meets it, and what is in the room."""

    name: str
    segments: tuple[tuple[float, ...], ...]  # x0, y0, x1, y1 [m], the outside on the left
    circles: tuple[tuple[float, ...], ...]  # x, y, radius [m]
    things: tuple[PlacedThing | PlacedBoard, ...]


class RemovedThing(msgspec.Struct, frozen=True):
    """The thing that was taken away."""

    id: str


class SpokenSound(msgspec.Struct, frozen=True):
    """Whose mouth speaks, where, and for how long there is something to say."""

    id: str
    seconds: float
    x_m: float
    y_m: float


class ListeningState(msgspec.Struct, frozen=True):
    """State of the microphones: listening without a pause or not."""

    on: bool


class ReadTruth(RobotRequest[GroundTruth], frozen=True, tag="truth"):
    """Ask for the robot's true pose."""


class ReadPlan(RobotRequest[FloorPlan], frozen=True, tag="plan"):
    """Ask for the true floor plan."""


class PlaceThing(RobotRequest[PlacedThing], frozen=True, tag="place"):
    """Put a box or a person there; one whose `id` exists is moved.

    A person keeps the clothes and the gesture that are not given, and with `path_m` walks along it from there.
    """

    what: Literal["person", "box"]
    x_m: float
    y_m: float
    heading_rad: float = 0.0
    id: str | None = None  # None: a new one
    size_m: float | None = None  # a box's edge, a person's height
    clothes: str | None = None  # "red/blue": shirt and trousers
    gesture: str | None = None
    path_m: tuple[Point, ...] | None = None
    speed_m_s: float | None = None
    again: bool | None = None  # in a round


class CarryRobot(RobotRequest[GroundTruth], frozen=True, tag="carry"):
    """Carry the robot itself there; its wheels do not notice."""

    x_m: float
    y_m: float
    heading_rad: float = 0.0


class BoardInCamera(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A board's pose in the camera's frame: P_camera = rotation · P_board + translation."""

    rotation: tuple[tuple[float, ...], ...]  # 3 rows of 3
    translation_m: tuple[float, ...]  # x, y, z of the first corner


class PlaceBoard(RobotRequest[PlacedBoard], frozen=True, tag="place_board"):
    """Hold up a chessboard, or move the one that is held.

    Its middle is at `x_m`, `y_m`, `z_m` with `rotation` (without one upright, facing the robot), or both are
    `in_camera`. With `holder` a person stands behind it.
    """

    columns: int = 9
    rows: int = 6
    square_m: float = 0.03
    panel_m: tuple[float, ...] | None = None  # width, height; None: half a square of rim around the print
    x_m: float | None = None
    y_m: float | None = None
    z_m: float | None = None
    rotation: tuple[tuple[float, ...], ...] | None = None  # 3 rows of 3, world from board
    in_camera: BoardInCamera | None = None
    seconds: float = 0.0  # [s] of the way from where it is now
    holder: bool = False


class RemoveThing(RobotRequest[RemovedThing], frozen=True, tag="remove"):
    """Take a thing, a person or the board away."""

    id: str


class Speak(RobotRequest[SpokenSound], frozen=True, tag="say"):
    """Speak from a place, or out of the mouth of the person of that `id`: a text, or samples.

    With `more` it goes on in the next request of the same `id`.
    """

    id: str | None = None
    x_m: float | None = None
    y_m: float | None = None
    z_m: float | None = None  # None: as high as a mouth
    text: str | None = None
    voice: str = ""  # see core.speech.synthesis; "": a person's
    speed: int | None = None  # [words a minute]
    pcm: bytes | None = None  # 16-bit samples of one channel, little endian
    rate_hz: int = 16_000
    more: bool = False


class Hush(RobotRequest[SpokenSound], frozen=True, tag="hush"):
    """Silence the person of that `id`: nothing that they were about to say sounds."""

    id: str


class SetListening(RobotRequest[ListeningState], frozen=True, tag="listen"):
    """Listen without a pause, or only for a while after someone spoke."""

    on: bool


# a recording


class PlaybackState(msgspec.Struct, frozen=True):
    """How a recording plays."""

    playing: bool
    speed: float  # times real time, as far as every scan has a frame
    position_s: float
    duration_s: float
    progress: float  # 0..1
    way: str = "computed"  # that is shown: "recorded" or "computed"
    compare: bool = False  # the other way is drawn over it
    ways: tuple[str, ...] = ("computed",)  # that the recording has
    computed_since_s: float | None = None  # where in the recording computing began; None: at its start, or nowhere
    reached: float | None = None  # times real time that is reached, where computing is slower than what was asked for


class PlaybackMark(msgspec.Struct, frozen=True):
    """Something that happened in a recording."""

    t_s: float  # from its start
    kind: str  # "command", "speech", "contact", "trip", "halt", "lost", "closure", "gap"
    text: str


class PlaybackMarks(msgspec.Struct, frozen=True):
    """All of them, in the order of time."""

    marks: tuple[PlaybackMark, ...]


class ReadMarks(RobotRequest[PlaybackMarks], frozen=True, tag="marks"):
    """Ask for the events of the recording."""


class ShowWay(RobotRequest[PlaybackState], frozen=True, tag="way"):
    """Show what was recorded, or what is computed now from the raw readings; with `compare` one over the other."""

    way: Literal["recorded", "computed"]
    compare: bool = False


class ReadPlayback(RobotRequest[PlaybackState], frozen=True, tag="state"):
    """How does it play?"""


class Play(RobotRequest[PlaybackState], frozen=True, tag="play"):
    """Go on; after the end from the start."""


class Pause(RobotRequest[PlaybackState], frozen=True, tag="pause"):
    """Stand still."""


class SetSpeed(RobotRequest[PlaybackState], frozen=True, tag="speed"):
    """Play so many times as fast as real time."""

    value: float


class Seek(RobotRequest[PlaybackState], frozen=True, tag="seek"):
    """Go on from there, a share of the whole from 0 to 1."""

    value: float


# the navigation that a real robot has of its own


class PlanarPose(msgspec.Struct, frozen=True):
    """A pose on a map."""

    x_m: float
    y_m: float
    heading_rad: float


class OwnMap(msgspec.Struct, frozen=True):
    """The robot's own occupancy map, as a picture that is small enough to be handed around."""

    png: bytes  # grey: 0 unknown, 1 free … 101 occupied; row 0 at the highest y of the map
    cell_m: float  # side of a picture element
    width_m: float
    height_m: float
    origin: PlanarPose  # of its lower left corner, in the map's frame
    frame: str


class OwnNavigation(msgspec.Struct, frozen=True, kw_only=True):
    """Report of the robot's own navigation, and the goal that it was given."""

    map: OwnMap | None  # None also where the asker knows it already
    map_number: int  # rises with every map; 0: none yet
    refused: str = ""  # why the newest map is not shown, a sentence
    pose: PlanarPose | None  # on its own map; None: it does not say
    stamp_s: float  # of the pose, robot clock
    known_from: str  # the topic that says where it is on its map: "/tf"; "": none
    takes_goals: str  # the topic; "": it takes none
    goal: PlanarPose | None  # the goal that it was given and that is under way


class ReadNavigation(RobotRequest[OwnNavigation], frozen=True, tag="navigation"):
    """Ask for the robot's own map, pose and goal. A map of the number that is known is left out."""

    known_map: int = 0


class SendGoal(RobotRequest[OwnNavigation], frozen=True, tag="goal"):
    """Let the robot's own navigation drive there, on its own map."""

    x_m: float
    y_m: float
    heading_rad: float = 0.0


SpeedsType = Literal["Twist", "TwistStamped"]


class SentSpeeds(msgspec.Struct, frozen=True):
    """The type as which speeds are sent."""

    type: SpeedsType


class SwitchSpeeds(RobotRequest[SentSpeeds], frozen=True, tag="speeds_type"):
    """Send speeds as this type from now on. Taken by a ROS robot that did not say it, so that it was guessed."""

    type: SpeedsType


class CancelGoal(RobotRequest[OwnNavigation], frozen=True, tag="cancel_goal"):
    """Let the robot's own navigation stand: its present pose becomes the goal."""


Requests = tuple[type[RobotRequest[Any]], ...]


class Ask(Protocol):
    """A way to the driver that is awaited. Raises BadInput, Refused or Unavailable with a sentence."""

    async def __call__(self, request: RobotRequest[AnswerT], /) -> AnswerT:
        """A request → its answer."""
        ...


class _Named(msgspec.Struct):
    do: str


def read_request(raw: bytes, known: Requests) -> RobotRequest[Any]:
    """JSON of a request → the request, which is one of `known`. Raises BadInput that says what is wrong with it."""
    kinds = {tag_of(kind): kind for kind in known}
    try:
        name = msgspec.json.decode(raw, type=_Named).do
        if name not in kinds:
            raise not_taken(known)
        return msgspec.json.decode(raw, type=kinds[name])
    except msgspec.DecodeError as wrong:
        raise BadInput(f"This request has not the form that is asked for: {plain(wrong)}.") from None


def read_answer(raw: bytes, request: RobotRequest[AnswerT]) -> AnswerT:
    """JSON of the answer to `request` → the answer. Raises BadInput when it is none."""
    try:
        return msgspec.json.decode(raw, type=answer_of(type(request)))
    except msgspec.DecodeError as wrong:
        raise BadInput(f"The driver's answer has not the form that is asked for: {plain(wrong)}.") from None


def not_taken(known: Requests) -> BadInput:
    """Return the error of a robot that is asked for what it does not know."""
    names = [tag_of(kind) for kind in known]
    return BadInput(
        f"This robot understands the requests {', '.join(names[:-1])} and {names[-1]}, nothing else."
        if len(names) > 1
        else f"This robot understands the request {names[0]}, nothing else."
        if names
        else "This robot takes no requests."
    )


def tag_of(kind: type[RobotRequest[Any]]) -> str:
    """Return the name of a kind of request in JSON."""
    return str(kind.__struct_config__.tag)


def answer_of(kind: type[RobotRequest[AnswerT]]) -> type[AnswerT]:
    """Return the struct with which a kind of request is answered."""
    return get_args(kind.__orig_bases__[0])[0]  # type: ignore[attr-defined]


def plain(wrong: msgspec.DecodeError) -> str:
    """The complaint of msgspec about a value, without its markup and its root."""
    return str(wrong).replace("`", "").replace(" - at $.", " as ")


def finite(value: float | None, key: str) -> float:
    """A number that must be there. Raises BadInput that names its `key`."""
    if value is None:
        raise BadInput(f"{key} must be a number.")
    if not math.isfinite(value):
        raise BadInput(f"{key} must be a finite number.")
    return float(value)
