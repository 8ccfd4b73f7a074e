"""The spoken command that waits: begin it at once, or drop it."""

from typing import Annotated

import msgspec
from pydantic import Field

from console.access.roles import needs
from console.api import RequestBody, Who, part, router
from console.control.pending_commands import PendingCommands

pending_command = router("pending_command", 404, 409)
Pending = Annotated[PendingCommands, part(PendingCommands)]


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
