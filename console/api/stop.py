"""Stop and halt. They act on the headers alone: no body can delay or break them."""

from __future__ import annotations

from typing import Any

from console.api import Behind, Who, router
from console.roles import needs

stop = router("stop")


@stop.post("/stop")
@needs("viewer", reads_body=False)
async def stop_now(behind: Behind, who: Who, press: str = "") -> dict[str, Any]:
    """Everything cancelled, zero speed; anyone signed in. Not latched.

    `press`: a number drawn anew with every press of STOP; a second stop of that number, by whatever way it comes,
    does nothing. What is no number is none: the stop acts.
    """
    behind.door.stop(who, "rest", int(press) if press.isascii() and press.isdigit() and len(press) < 17 else 0)
    return {"stopped": True}


@stop.post("/halt")
@needs("viewer", reads_body=False)
async def halt(behind: Behind, who: Who) -> dict[str, Any]:
    """A stop that stays until it is reset, over a restart too."""
    behind.door.halt(who, "rest")
    return {"halted": True}


@stop.post("/halt/reset")
@needs("operator", reads_body=False)
async def reset(behind: Behind, who: Who) -> dict[str, Any]:
    """Undo the halt; the lease holder only. Never moves."""
    behind.door.reset(who, "rest")
    return {"halted": False}
