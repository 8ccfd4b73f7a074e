"""Commands, and a spoken one that waits, as they go over the sockets."""

import msgspec

from core.commands.command import Target

Struct = msgspec.Struct


class CommandPayload(Struct):
    """A command as it was understood."""

    id: int
    name: str
    numbers: dict[str, float]
    heard_as: str
    source: str
    who: str


class PendingCommandState(CommandPayload):
    """A spoken command that was understood and has not begun, and its preview as the robot stands now."""

    begins_in_s: float
    delay_s: float  # that it waits in all
    target: Target
    uncertain: bool  # a number in it may have been another: the decision was to confirm it
    alternatives: list[str]  # the commands that it may have been, the likeliest first
    way: list[tuple[float, float]]  # in the world frame; a straight line or an arc, not a plan
    goal: tuple[float, float] | None  # in the world frame
    heading_rad: float | None  # to which it would turn; world
    bearing_rad: float | None  # of who spoke, in the robot's frame as it stands now
    bearing_sd_rad: float | None


class LateCommandState(Struct):
    """A spoken command that was refused because it came too late; it begins as a pending command does."""

    id: int
    heard_as: str
