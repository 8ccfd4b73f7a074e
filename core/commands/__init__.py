"""Table 2: what the robot can be told. One file per command, listed in VOCABULARY."""

from __future__ import annotations

from collections.abc import Mapping

from core.commands.come_here import COME_HERE
from core.commands.command import Kind
from core.commands.continue_straight import CONTINUE
from core.commands.follow_me import FOLLOW_ME
from core.commands.follow_wall import FOLLOW_WALL
from core.commands.stand import START, STOP_MOVING
from core.commands.stop_at import STOP_AT
from core.commands.turn import TURN_LEFT, TURN_RIGHT

VOCABULARY: tuple[Kind, ...] = (
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
"""Every command, in the order of Table 2; the words are those of `Kind.words`."""


def kind_of(name: str) -> Kind:
    """The command of that name. Raises KeyError."""
    return next(kind for kind in VOCABULARY if kind.name == name)


def particulars(name: str, numbers: Mapping[str, float]) -> dict[str, float | str]:
    """What JSON tells of a command beside its name: its numbers, and what is no number."""
    return {**numbers, "side": "right"} if name == FOLLOW_WALL.name else dict(numbers)
