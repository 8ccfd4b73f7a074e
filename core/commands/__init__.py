"""Table 2: what the robot can be told. One file per command, listed in VOCABULARY."""

from __future__ import annotations

from core.commands.come_here import COME_HERE
from core.commands.command import Kind
from core.commands.continue_straight import CONTINUE
from core.commands.follow_me import FOLLOW_ME
from core.commands.stand import START, STOP_MOVING
from core.commands.stop_at import STOP_AT
from core.commands.turn import TURN_LEFT, TURN_RIGHT

VOCABULARY: tuple[Kind, ...] = (TURN_LEFT, TURN_RIGHT, STOP_MOVING, CONTINUE, STOP_AT, COME_HERE, FOLLOW_ME, START)
"""Every command, in the order of Table 2; the words are those of `Kind.words`."""


def kind_of(name: str) -> Kind:
    """The command of that name. Raises KeyError."""
    return next(kind for kind in VOCABULARY if kind.name == name)
