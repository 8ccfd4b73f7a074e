"""The spoken order that waits: begin it at once, or drop it."""

from __future__ import annotations

from typing import Any

from pydantic import Field

from console.api import Behind, Who, Wish, router
from console.roles import needs

intent = router("intent")


class Waiting(Wish):
    """Which order: the `id` that `intent` in the state has. It begins by itself when its moment is over."""

    id: int = Field(ge=1, le=2**53)


@intent.post("/intent/begin", status_code=202)
@needs("operator")
async def begin(order: Waiting, behind: Behind, who: Who) -> dict[str, Any]:
    """Begin the waiting order at once; the driver only. `deed` is its number in the history."""
    deed = behind.intents.begin(order.id, who)
    return {"id": order.id, "deed": deed.id, "heard_as": deed.heard_as}


@intent.post("/intent/drop")
@needs("viewer")
async def drop(order: Waiting, behind: Behind, who: Who) -> dict[str, Any]:
    """Drop the waiting order: it does not begin. Whoever may stop the robot may do this."""
    behind.intents.drop(order.id, who)
    return {"id": order.id, "dropped": True}
