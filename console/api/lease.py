"""The lease: the right to drive."""

import time

from console.access.roles import needs
from console.api import Dispatcher, OperatorLease, RequestBody, Who, router
from console.control.dispatcher import LeaseAction
from console.messages.state import LeaseState
from console.state_view import lease as lease_state

lease = router("lease", 409)


class LeaseRequest(RequestBody):
    """Take control, renew it, take it over, give it back; ask who has it; give it to who asks, or keep it."""

    do: LeaseAction


@lease.get("/lease")
@needs("viewer")
async def held(lease: OperatorLease) -> LeaseState:
    """The operator who drives now."""
    return lease_state(lease, time.monotonic())


@lease.post("/lease")
@needs("operator")
async def change(asked: LeaseRequest, dispatcher: Dispatcher, lease: OperatorLease, who: Who) -> LeaseState:
    """Take control. A take-over goes through zero. `ask`: the holder sees it for 10 s and may `give` or `keep`.

    The lease lapses, and what is under way is cancelled, after 5 s without a sign of life of its holder: a message of
    their page on `/ws`, or any request of theirs. A program that sent an endless command (follow wall, follow me)
    sends `{"do": "renew"}` every second while it wants the robot to go on; what ends by itself (continue, stop at …)
    keeps the lease until it has ended. Who does not drive renews nothing: 409.
    """
    dispatcher.change_lease(asked.do, who)
    return lease_state(lease, time.monotonic())
