"""Stop and halt. They act on the headers alone: no body can delay or break them."""

from __future__ import annotations

from typing import Any

from console.access.roles import needs
from console.api import Behind, Who, router
from console.control.stop import latched

stop = router("stop")


@stop.post("/stop")
@needs("viewer", reads_body=False)
async def stop_now(behind: Behind, who: Who, press: str = "") -> dict[str, Any]:
    """Everything cancelled, zero speed; anyone signed in. Not latched.

    `press`: a number drawn with every press of STOP. The stop always acts; one that comes again with the number of
    the last two seconds, as when a press goes by two ways, is not recorded again.
    """
    behind.door.stop(who, "rest", number(press))
    return {"stopped": True}


@stop.post("/halt")
@needs("viewer", reads_body=False)
async def halt(behind: Behind, who: Who, press: str = "") -> dict[str, Any]:
    """A stop that stays until it is reset, over a restart too. `press` as of a stop.

    It answers when the halt is on disk: `latched` true. Where that fails it is false, and `why` says what is wrong.
    """
    behind.door.halt(who, "rest", number(press))
    why_not = await latched(behind.robot, behind.board)
    return {"halted": True, "latched": not why_not, **({"why": why_not} if why_not else {})}


@stop.post("/halt/reset")
@needs("operator", reads_body=False)
async def reset(behind: Behind, who: Who) -> dict[str, Any]:
    """Undo the halt; the lease holder only. Never moves."""
    behind.door.reset(who, "rest")
    return {"halted": False}


def number(press: str) -> int:
    """A press of STOP or Halt; 0 when it has no number, for no number makes a stop fail."""
    return int(press) if press.isascii() and press.isdigit() and len(press) < 17 else 0
