"""Words for the robot, and what became of them."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import Query, Response
from pydantic import Field

from console.api import Behind, Who, Wish, router
from console.problems import Problem
from console.roles import needs
from console.store import REMEMBERED, Deed
from core.commands import VOCABULARY, particulars
from core.commands.command import Kind

commands = router("commands")


class Words(Wish):
    """What the robot is told."""

    text: str = Field(max_length=2000, examples=["turn left", "continue 1.5 meters", "stop at 1 and 0.5"])


@commands.post("/commands", status_code=202)
@needs("viewer")
async def submit(words: Words, behind: Behind, who: Who, response: Response) -> dict[str, Any]:
    """Understand words and obey them. Viewers may only stop.

    Follow wall and follow me have no end of their own: they are cancelled after 5 s without a sign of life of their
    sender. See `POST /api/lease`. 409 with “already doing that” leaves what is under way alone.
    """
    deed = behind.door.submit(words.text, "rest", who)
    response.headers["Location"] = f"commands/{deed.id}"
    return {
        "id": deed.id,
        "command": {"name": deed.name, **particulars(deed.name, deed.numbers)},
        "heard_as": deed.heard_as,
        "source": deed.source,
    }


@commands.get("/commands")
@needs("viewer")
async def vocabulary() -> dict[str, Any]:
    """Table 2: words, parameters, bounds."""
    return {"commands": [row_of(kind) for kind in VOCABULARY]}


@commands.get("/commands/history")
@needs("viewer")
async def history(behind: Behind, limit: Annotated[int, Query(ge=1, le=REMEMBERED)] = REMEMBERED) -> dict[str, Any]:
    """What was heard, from whom, and how it ended; newest first, `limit` of them at most."""
    deeds = behind.history.newest_first(commands_only=True, limit=limit)
    return {"revision": behind.history.revision, "commands": [told(deed) for deed in deeds]}


@commands.get("/commands/{number}")
@needs("viewer")
async def one(number: int, behind: Behind) -> dict[str, Any]:
    """How one command goes, or how it ended."""
    deed = behind.history.find(number)
    if deed is None or deed.what != "command":
        raise Problem(404, "There is no such command since the console started.")
    return told(deed)


@commands.get("/audit")
@needs("operator")
async def audit(behind: Behind) -> dict[str, Any]:
    """Whatever gave, took, bounded or ended motion; newest first."""
    return {"deeds": [told(deed) for deed in behind.history.newest_first(commands_only=False)]}


def row_of(kind: Kind) -> dict[str, Any]:
    """One row of Table 2."""
    return {
        "name": kind.name,
        "words": list(kind.words),
        "example": kind.example,
        "summary": kind.summary,
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


def told(deed: Deed) -> dict[str, Any]:
    """A row of the history."""
    return {
        "id": deed.id,
        "what": deed.what,
        "words": deed.words,
        "name": deed.name,
        "numbers": deed.numbers,
        "heard_as": deed.heard_as,
        "source": deed.source,
        "who": deed.who,
        "role": deed.role,
        "state": deed.state,
        "remark": deed.remark,
        "at_s": deed.wall,
        "ended_s": deed.ended,
        "duration_s": None if deed.ended is None else round(deed.ended - deed.wall, 3),
    }
