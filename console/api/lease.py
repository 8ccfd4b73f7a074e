"""Who drives."""

from __future__ import annotations

from typing import Any, Literal

import msgspec

from console.api import Behind, Who, Wish, router
from console.portrait import lease as lease_state
from console.roles import needs

lease = router("lease")


class LeaseWish(Wish):
    """Take the wheel, show that the driver is still there, take it over from somebody, give it back."""

    do: Literal["acquire", "renew", "take", "release"]


@lease.get("/lease")
@needs("viewer")
async def held(behind: Behind) -> dict[str, Any]:
    """Who drives now."""
    return msgspec.to_builtins(lease_state(behind.lease))


@lease.post("/lease")
@needs("operator")
async def wish(asked: LeaseWish, behind: Behind, who: Who) -> dict[str, Any]:
    """Ask for the wheel. A take-over goes through zero.

    The lease lapses, and what is under way is cancelled, after 5 s without a sign of life of its holder: a message of
    their page on `/ws`, or any request of theirs. A program that sent an endless command (follow wall, follow me)
    sends `{"do": "renew"}` every second while it wants the robot to go on; what ends by itself (continue, stop at …)
    keeps the lease until it has ended. Who does not drive renews nothing: 409.
    """
    behind.door.wish(asked.do, who)
    return msgspec.to_builtins(lease_state(behind.lease))
