"""Commands for the robot, and how they ended."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import Query, Response
from pydantic import Field

from console.access.roles import needs
from console.api import Behind, RequestBody, Who, router
from console.control.history_store import REMEMBERED, HistoryEntry
from console.http.problems import Problem
from core.commands import VOCABULARY, particulars
from core.commands.command import CommandSpec

commands = router("commands")


class CommandRequest(RequestBody):
    """A command for the robot, in words."""

    text: str = Field(max_length=2000, examples=["turn left", "continue 1.5 meters", "stop at 1 and 0.5"])


@commands.post("/commands", status_code=202)
@needs("viewer")
async def submit(words: CommandRequest, behind: Behind, who: Who, response: Response) -> dict[str, Any]:
    """Understand words and obey them. Viewers may only stop.

    Follow wall and follow me have no end of their own: they are cancelled after 5 s without a sign of life of their
    sender. See `POST /api/lease`. 409 with “already doing that” leaves what is under way alone.
    """
    entry = behind.door.submit(words.text, "rest", who)
    response.headers["Location"] = f"commands/{entry.id}"
    return {
        "id": entry.id,
        "command": {"name": entry.name, **particulars(entry.name, entry.numbers)},
        "heard_as": entry.heard_as,
        "source": entry.source,
    }


@commands.get("/commands")
@needs("viewer")
async def vocabulary() -> dict[str, Any]:
    """Table 2: words, parameters, bounds."""
    return {"commands": [row_of(kind) for kind in VOCABULARY]}


@commands.get("/commands/history")
@needs("viewer")
async def history(behind: Behind, limit: Annotated[int, Query(ge=1, le=REMEMBERED)] = REMEMBERED) -> dict[str, Any]:
    """The newest commands, each with its sender and how it ended; newest first, at most `limit`."""
    entries = behind.history.newest_first(commands_only=True, limit=limit)
    return {"revision": behind.history.revision, "commands": [entry_row(entry) for entry in entries]}


@commands.get("/commands/{number}")
@needs("viewer")
async def one(number: int, behind: Behind) -> dict[str, Any]:
    """How one command goes, or how it ended."""
    entry = behind.history.find(number)
    if entry is None or entry.what != "command":
        raise Problem(404, "There is no such command since the console started.")
    return entry_row(entry)


@commands.get("/audit")
@needs("operator")
async def audit(behind: Behind) -> dict[str, Any]:
    """All events that gave, took, bounded or ended motion; newest first."""
    return {"entries": [entry_row(entry) for entry in behind.history.newest_first(commands_only=False)]}


def row_of(kind: CommandSpec) -> dict[str, Any]:
    """One row of Table 2."""
    return {
        "name": kind.name,
        "words": list(kind.words),
        "example": kind.example,
        "summary": kind.summary,
        "icon": kind.icon,
        "target": kind.target,
        "endless": kind.endless,
        "numbers": [
            {
                "name": number.name,
                "says": number.says,
                "unit": number.unit,
                "low": number.low,
                "high": number.high,
                "default": number.default,
            }
            for number in kind.numbers
        ],
    }


def entry_row(entry: HistoryEntry) -> dict[str, Any]:
    """A row of the history."""
    return {
        "id": entry.id,
        "what": entry.what,
        "words": entry.words,
        "name": entry.name,
        "numbers": entry.numbers,
        "heard_as": entry.heard_as,
        "source": entry.source,
        "who": entry.who,
        "role": entry.role,
        "state": entry.state,
        "remark": entry.remark,
        "at_s": entry.wall,
        "ended_s": entry.ended,
        "duration_s": None if entry.ended is None else round(entry.ended - entry.wall, 3),
    }
