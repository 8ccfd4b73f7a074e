"""A spoken order that was understood and waits: who gave it, what it is, when it begins."""

from __future__ import annotations

from dataclasses import dataclass

from console.fresh_words import Said
from console.logins import Person
from core.commands.careful import Moment
from core.commands.command import Command


@dataclass(frozen=True)
class Intent:
    """An order that waits."""

    id: int
    person: Person  # in whose name it begins
    source: str
    words: str
    command: Command
    moment: float  # [s] that it waits in all
    when: Moment  # it begins, on the monotonic clock
    said: Said  # its words
    unsure: bool = False  # a number in it may have been another
