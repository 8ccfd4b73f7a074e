"""Table 2: the vocabulary of the robot. One file per command, listed in VOCABULARY."""

from collections.abc import Mapping

from core.commands.come_here import COME_HERE
from core.commands.command import Command, CommandSpec
from core.commands.continue_straight import CONTINUE
from core.commands.follow_me import FOLLOW_ME
from core.commands.follow_wall import FOLLOW_WALL
from core.commands.routes import ROUTE_COMMANDS
from core.commands.stop_at import STOP_AT
from core.commands.stop_moving import START, STOP_MOVING
from core.commands.turn import TURN_LEFT, TURN_RIGHT

VOCABULARY: tuple[CommandSpec, ...] = (
    TURN_LEFT,
    TURN_RIGHT,
    STOP_MOVING,
    CONTINUE,
    STOP_AT,
    FOLLOW_WALL,
    COME_HERE,
    FOLLOW_ME,
    START,
)
"""Every command, in the order of Table 2; the words are those of `CommandSpec.words`."""
SPECS = {spec.name: spec for spec in (*VOCABULARY, *ROUTE_COMMANDS)}


def spec_of(name: str) -> CommandSpec:
    """Find the command of that name. Raises KeyError."""
    return SPECS[name]


def needs_confirmation(command: Command) -> bool:
    """Return whether a command waits for the confirmation delay, however surely it was heard."""
    return spec_of(command.name).needs_confirmation(command.numbers)


def has_said_numbers(command: Command) -> bool:
    """Return whether its words hold numbers, rather than numbers that are always the same."""
    return any(number.default is None for number in spec_of(command.name).numbers)


def particulars(name: str, numbers: Mapping[str, float]) -> dict[str, float | str]:
    """Return what JSON says of a command besides its name: its numbers, and its fixed parameters."""
    return {**numbers, **spec_of(name).fixed}
