"""Who drives."""

from __future__ import annotations

from typing import Any, Literal

import msgspec

from console.api import Behind, Who, Wish, router
from console.portrait import lease as lease_state
from console.roles import needs

lease = router("lease")


class LeaseWish(Wish):
    """Take the wheel, take it over from somebody, give it back."""

    do: Literal["acquire", "take", "release"]


@lease.get("/lease")
@needs("viewer")
async def held(behind: Behind) -> dict[str, Any]:
    """Who drives now."""
    return msgspec.to_builtins(lease_state(behind.lease))


@lease.post("/lease")
@needs("operator")
async def wish(asked: LeaseWish, behind: Behind, who: Who) -> dict[str, Any]:
    """Ask for the wheel. A take-over goes through zero."""
    behind.door.wish(asked.do, who)
    return msgspec.to_builtins(lease_state(behind.lease))
