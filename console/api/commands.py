"""Commands for the robot, how they ended, and the spoken one that waits: begin it at once, or drop it."""

from typing import Annotated

import msgspec
from fastapi import Query, Response
from pydantic import Field

from console.access.roles import needs
from console.api import Angle, Behind, Dispatcher, HistoryInUse, RequestBody, Who, part, router
from console.control.history_store import MAX_REMEMBERED_ENTRIES, HistoryEntry
from console.control.pending_commands import PendingCommands
from console.http.problems import Problem
from core.commands import VOCABULARY, particulars
from core.commands.command import CommandSpec
from core.geometry import wrap
from core.perception.people.voice_bearing import VoiceBearing
from core.sentences import code_of
from core.snapshot import Snapshot

commands = router("commands", 409, 503)

POINTED_SD_RAD = 0.1  # sd of a direction that an operator gives
pending_command = router("pending_command", 404, 409)
Pending = Annotated[PendingCommands, part(PendingCommands)]


class CommandRequest(RequestBody):
    """A command for the robot, in words."""

    text: str = Field(max_length=2000, examples=["turn left", "continue 1.5 meters", "stop at 1 and 0.5"])
    towards_rad: Angle | None = None  # world: where the person is whom it goes to


class CommandReceipt(msgspec.Struct, frozen=True):
    """A command that began, under its number in the history."""

    id: int
    command: dict[str, float | str]  # `name`, and the command's numbers and fixed parameters
    heard_as: str
    source: str


class ParameterRow(msgspec.Struct, frozen=True):
    """A parameter of a command, and its bounds."""

    name: str
    says: str  # how Table 2 writes it
    unit: str
    low: float
    high: float
    default: float | None


class VocabularyRow(msgspec.Struct, frozen=True):
    """A row of Table 2."""

    name: str
    words: tuple[str, ...]
    example: str
    summary: str
    icon: str
    target: str
    endless: bool
    numbers: list[ParameterRow]


class Vocabulary(msgspec.Struct, frozen=True):
    """Table 2."""

    commands: list[VocabularyRow]


class HistoryRow(msgspec.Struct, frozen=True, kw_only=True):
    """A command or another event: from whom, and how it ended."""

    id: int
    what: str
    words: str  # as they arrived
    name: str
    numbers: dict[str, float]
    heard_as: str  # as they were understood
    source: str
    who: str
    role: str
    state: str
    remark: str
    at_s: float  # Unix time
    ended_s: float | None
    duration_s: float | None
    code: str | None = None  # of the sentence in `remark`, which keeps its meaning in every language
    values: dict[str, str] | None = None  # in that sentence, by their names


class CommandHistory(msgspec.Struct, frozen=True):
    """The newest commands; `revision` rises with every change."""

    revision: int
    commands: list[HistoryRow]


class AuditLog(msgspec.Struct, frozen=True):
    """The newest events."""

    entries: list[HistoryRow]


@commands.post("/commands", status_code=202)
@needs("viewer")
async def submit(
    words: CommandRequest, dispatcher: Dispatcher, behind: Behind, who: Who, response: Response
) -> CommandReceipt:
    """Understand words and obey them. Viewers may only stop.

    Come here and follow me go to the voice that was heard last, or with `towards_rad` to who is in that direction.

    Follow wall and follow me have no end of their own: they are cancelled after 5 s without a sign of life of their
    sender. See `POST /api/lease`. 409 with “already” leaves what is under way alone.
    """
    call = None if words.towards_rad is None else pointed(words.towards_rad, behind.snapshot)
    entry = dispatcher.submit(words.text, "rest", who, call=call)
    response.headers["Location"] = f"commands/{entry.id}"
    command = {"name": entry.name, **particulars(entry.name, entry.numbers)}
    return CommandReceipt(entry.id, command, entry.heard_as, entry.source)


@commands.get("/commands")
@needs("viewer")
async def vocabulary() -> Vocabulary:
    """Table 2: words, parameters, bounds."""
    return Vocabulary([row_of(kind) for kind in VOCABULARY])


@commands.get("/commands/history")
@needs("viewer")
async def history(
    history: HistoryInUse, limit: Annotated[int, Query(ge=1, le=MAX_REMEMBERED_ENTRIES)] = MAX_REMEMBERED_ENTRIES
) -> CommandHistory:
    """The newest commands, each with its sender and how it ended; newest first, at most `limit`."""
    entries = history.newest_first(commands_only=True, limit=limit)
    return CommandHistory(history.revision, [entry_row(entry) for entry in entries])


@commands.get("/commands/{number}")
@needs("viewer")
async def one(number: int, history: HistoryInUse) -> HistoryRow:
    """How one command goes, or how it ended."""
    entry = history.find(number)
    if entry is None or entry.what != "command":
        raise Problem(404, "There is no such command since the console started.")
    return entry_row(entry)


@commands.get("/audit")
@needs("operator")
async def audit(history: HistoryInUse) -> AuditLog:
    """All events that gave, took, bounded or ended motion; newest first."""
    return AuditLog([entry_row(entry) for entry in history.newest_first(commands_only=False)])


def pointed(azimuth: float, snapshot: Snapshot | None) -> VoiceBearing:
    """The bearing of a person at whom an operator points, in the world, from where the robot is now. Problem 503."""
    if snapshot is None:
        raise Problem(503, "The robot has not said yet where it is.")
    here = snapshot.estimate.pose
    return VoiceBearing(stamp=snapshot.stamp, azimuth=wrap(azimuth), sd=POINTED_SD_RAD, x=here.x, y=here.y)


def row_of(kind: CommandSpec) -> VocabularyRow:
    """One row of Table 2."""
    return msgspec.convert(kind, VocabularyRow, from_attributes=True)


def entry_row(entry: HistoryEntry) -> HistoryRow:
    duration = None if entry.ended is None else round(entry.ended - entry.wall, 3)
    times = {"at_s": entry.wall, "ended_s": entry.ended, "duration_s": duration}
    return msgspec.convert({**vars(entry), **times, **code_of(entry.remark)._asdict()}, HistoryRow)


class PendingCommandRequest(RequestBody):
    """Which command: the `id` that `pending_command` in the state has. It begins by itself after its delay."""

    id: int = Field(ge=1, le=2**53)


class BegunCommand(msgspec.Struct, frozen=True):
    """The command that waited, and its number in the history."""

    id: int
    entry: int
    heard_as: str


class DroppedCommand(msgspec.Struct, frozen=True):
    """The command that does not begin."""

    id: int
    dropped: bool = True


@pending_command.post("/pending-command/begin", status_code=202)
@needs("operator")
async def begin(asked: PendingCommandRequest, pending_commands: Pending, who: Who) -> BegunCommand:
    """Begin the waiting command at once; the operator in control only. `entry` is its number in the history."""
    entry = pending_commands.begin(asked.id, who)
    return BegunCommand(asked.id, entry.id, entry.heard_as)


@pending_command.post("/pending-command/drop")
@needs("viewer")
async def drop(asked: PendingCommandRequest, pending_commands: Pending, who: Who) -> DroppedCommand:
    """Drop the pending command: it does not begin. Anyone who may stop the robot may do this."""
    pending_commands.drop(asked.id, who)
    return DroppedCommand(asked.id)
