"""The connection to the robot: topics, parts and mountings that were found, and the robot file made of them."""

import math
import time
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from typing import Annotated, TypeVar, cast

import msgspec
from msgspec import structs
from pydantic import Field

from console.access.logins import Person
from console.access.roles import needs
from console.api import Angle, HistoryInUse, Operator, OperatorLease, RequestBody, part, router
from console.connection.reach import masked
from console.connection.service import LONGEST_URL, REAL_ONLY, ConnectionService, FoundAddresses, WrittenFile
from console.control.history import History
from console.http.problems import Problem
from core.errors import BeckonError, Refused
from core.robots.connection import FoundRobot
from core.robots.requests import SentSpeeds, SpeedsType
from core.robots.robot_file import (
    CameraTable,
    ChosenRole,
    LaserTable,
    MicrophonesTable,
    RobotFile,
    TopicChoice,
    converted,
)

Table = TypeVar("Table", LaserTable, CameraTable, MicrophonesTable)

connection = router("connection", 409, 503, 507)
RobotConnection = Annotated[ConnectionService, part(ConnectionService)]

LOOK = "look at robot"  # of the history
Url = Annotated[str, Field(min_length=3, max_length=LONGEST_URL, examples=["foxglove://192.168.0.7:8765"])]
Name = Annotated[str, Field(min_length=1, max_length=60)]
Topic = Annotated[str, Field(min_length=1, max_length=200)]
Place = Annotated[float, Field(ge=-10, le=10)]
Length = Annotated[float, Field(gt=0, le=10)]


class FoundConnection(msgspec.Struct, frozen=True, kw_only=True):
    """Findings on the console's robot, and the robot files that were written before."""

    connection: FoundRobot
    why_not: str  # why no robot file can be written for it, a sentence; "" where one can
    files: list[str]  # names of robot files in the data folder
    opened_here: list[str]  # URLs of recordings and simulated robots that can be opened instead; none on a real robot


class TopicChoiceRequest(RequestBody):
    """The topics for a role on a part of the URL, counted from 0; none of them switches the role off."""

    part: int = Field(default=0, ge=0, le=20)
    role: ChosenRole
    topics: list[Topic] = Field(max_length=2)


class ProbeRequest(RequestBody):
    """A robot to look at, and topics that are not to be guessed."""

    url: Url
    topics: list[TopicChoiceRequest] = Field(default=[], max_length=60)


class OpenRobotRequest(RequestBody):
    """A recording (`log:FILE`, a whole path or a name in the data folder's recordings) or a simulated robot."""

    url: Annotated[str, Field(min_length=3, max_length=LONGEST_URL, examples=["log:walk.mcap"])]


class SpeedsTypeRequest(RequestBody):
    """The type as which speeds are sent from now on."""

    type: SpeedsType


class OpenedRobot(msgspec.Struct, frozen=True):
    """The URL that is opened; the console starts again with it, at the same address."""

    url: str


class LaserPlace(RequestBody):
    """Mounting of a laser, and what is added to its stamps. Without `x_m`, the driver's own place holds."""

    x_m: Place | None = None
    y_m: Place = 0.0
    heading_rad: Angle = 0.0
    height_m: Length | None = None
    time_offset_s: float = Field(default=0.0, ge=-1, le=1)


class CameraPlace(RequestBody):
    """Mounting of a camera: yaw to the left, pitch downwards, roll clockwise seen from behind.

    Without `x_m`, the driver's own place holds.
    """

    x_m: Place | None = None
    y_m: Place = 0.0
    z_m: Place = 0.16
    yaw_rad: Angle = 0.0
    pitch_rad: Angle = 0.0
    roll_rad: Angle = 0.0


class MicrophonesPlace(RequestBody):
    """Mounting of a microphone array."""

    x_m: Place = 0.0
    y_m: Place = 0.0
    heading_rad: Angle = 0.0
    height_m: Length = 0.25


class RobotFileRequest(ProbeRequest):
    """All that the operator confirmed; `replace`: also when there is a robot file of that name already.

    What is left out is as before, or as the robot says it.
    """

    name: Name
    radius_m: Length | None = None
    wheelbase_m: Length | None = None
    cruise_m_s: float | None = Field(default=None, gt=0, le=5)
    max_speed_m_s: float | None = Field(default=None, gt=0, le=5)
    max_turn_rate_rad_s: float | None = Field(default=None, gt=0, le=20)
    lasers: dict[str, LaserPlace] = Field(default={}, max_length=20)
    cameras: dict[str, CameraPlace] = Field(default={}, max_length=20)
    microphones: dict[str, MicrophonesPlace] = Field(default={}, max_length=20)
    replace: bool = False


@connection.get("/robot/connection")
@needs("viewer")
async def found(robot: RobotConnection) -> FoundConnection:
    """Parts, topics with their types, frames and rates, sensors and mountings of the console's robot."""
    why_not = "" if robot.real else REAL_ONLY
    return FoundConnection(
        connection=await robot.found(),
        why_not=why_not,
        files=await robot.files(),
        opened_here=await robot.opened_here(),
    )


@connection.post("/robot/probe")
@needs("operator")
async def probe(asked: ProbeRequest, robot: RobotConnection, who: Operator, history: HistoryInUse) -> FoundRobot:
    """Connect to a robot, which may be another one, listen for two seconds and let go. Nothing is driven.

    Administrators name any robot; operators the one that is driven, and what `--connect` allows them.
    """
    with recorded(history, LOOK, who, asked.url):
        return await robot.look(asked.url, choices(asked), who)


@connection.post("/robot/find")
@needs("operator")
async def find(robot: RobotConnection, who: Operator, history: HistoryInUse) -> FoundAddresses:
    """Robots that answer on this computer, and at hosts that were looked at or written into robot files before.

    Only a connection is opened there; serial ports are named to administrators.
    """
    entries = history.newest_first(commands_only=False)
    return await robot.find([entry.words for entry in entries if entry.what == LOOK], who)


@connection.post("/robot/open", status_code=202)
@needs("operator")
async def open_instead(
    asked: OpenRobotRequest, robot: RobotConnection, lease: OperatorLease, who: Operator, history: HistoryInUse
) -> OpenedRobot:
    """Open a recording or a simulated robot instead of this one. What drives is stopped; a real robot is kept.

    A recording is read first: one that cannot be used is a 422 with the reader's sentence, and nothing ends. A map
    that is not saved is kept as “before opening …”.
    """
    with recorded(history, "open robot", who, asked.url):
        url = await robot.readable(asked.url, who)
        lease.check_not_anothers(who)  # control may have changed hands meanwhile
        robot.open_instead(url)
    return OpenedRobot(url=url)


@connection.post("/robot/speeds_type")
@needs("operator")
async def switch_speeds(
    asked: SpeedsTypeRequest, robot: RobotConnection, lease: OperatorLease, who: Operator, history: HistoryInUse
) -> SentSpeeds:
    """Send speeds as Twist or TwistStamped from now on, where the robot does not say which it takes.

    Nothing moves by the new type before zero was asked for. It holds until the console ends; a robot file keeps it.
    """
    lease.check_not_anothers(who)
    with recorded(history, "type of speeds", who, asked.type):
        return await robot.switch_speeds(asked.type)


@connection.post("/robot/file", status_code=201)
@needs("operator")
async def write(asked: RobotFileRequest, robot: RobotConnection, who: Operator, history: HistoryInUse) -> WrittenFile:
    """Write a robot file into the data folder, with which the console can be started again."""
    file = confirmed(await robot.chosen(asked.url, choices(asked)), asked)
    day = time.strftime("%Y-%m-%d %H:%M")
    written = await robot.write(file, f"Written by {who.name}, {day}. Start it with:", who, replace=asked.replace)
    history.add("robot file", who, words=written.name, remark=masked(asked.url))
    return written


@contextmanager
def recorded(history: History, what: str, who: Person, url: str) -> Generator[None]:
    """An entry of the history with the whole URL, without its passwords, and with how it ended."""
    entry = history.add(what, who, state="running", words=masked(url))
    ended, remark = "failed", "It was broken off."
    try:
        yield
        ended, remark = "done", ""
    except Problem as problem:
        ended, remark = "refused", problem.detail
        raise
    except BeckonError as error:
        ended, remark = "refused" if isinstance(error, Refused) else "failed", str(error)
        raise
    finally:
        history.end(entry.id, ended, remark)


def choices(asked: ProbeRequest) -> list[TopicChoice]:
    return [TopicChoice(part=one.part, role=one.role, topics=tuple(one.topics)) for one in asked.topics]


def confirmed(file: RobotFile, asked: RobotFileRequest) -> RobotFile:
    """A robot file with what the operator confirmed. Raises BadInput for a value out of bounds."""
    figures = {
        "radius": asked.radius_m,
        "wheelbase": asked.wheelbase_m,
        "cruise": asked.cruise_m_s,
        "max_speed": asked.max_speed_m_s,
        "max_turn_rate": asked.max_turn_rate_rad_s,
    }
    given = {key: value for key, value in figures.items() if value is not None}
    lasers = {name: placed(file.lasers.get(name, LaserTable()), place) for name, place in asked.lasers.items()}
    cameras = {name: placed(file.cameras.get(name, CameraTable()), place) for name, place in asked.cameras.items()}
    microphones = {
        name: placed(file.microphones.get(name, MicrophonesTable()), place)
        for name, place in asked.microphones.items()
    }
    whole = structs.replace(
        file,
        name=" ".join(asked.name.split()),
        lasers={**file.lasers, **lasers},
        cameras={**file.cameras, **cameras},
        microphones={**file.microphones, **microphones},
        **given,
    )
    return converted(cast(Mapping[str, object], msgspec.to_builtins(whole)), RobotFile, "The robot file")


def placed(table: Table, place: RequestBody) -> Table:
    """A sensor's table of a robot file at this place: entries without units, angles in degrees."""
    entries: dict[str, float | None] = {}
    for key, value in place:
        name, _, unit = key.rpartition("_")
        entries |= {f"{name}_deg": degrees(value)} if unit == "rad" else {name: value}
    return structs.replace(table, **entries)


def degrees(angle: float) -> float:
    """An angle [rad] as a robot file has it [°]."""
    return round(math.degrees(angle), 4) + 0.0
