"""When spoken orders begin: soon after the words or not at all; some wait a moment, in which STOP holds them back."""

from __future__ import annotations

from dataclasses import dataclass, replace

from core.commands.command import Command

OBEYED_WITHIN = 2.0  # [s] after their end that words are still obeyed
CAREFUL = ("come_here", "follow_me", "stop_at")
FAR = 2.0  # [m]
MOMENT = 2.0  # [s]
READING = 1.2  # [s] after somebody spoke, in which a STOP of theirs can have been read
LONGEST = 4.0  # [s] by which a room that never falls silent puts an order off


def is_careful(command: Command) -> bool:
    """Whether an order waits a moment, however surely it was heard: it goes far, or to a place or a person."""
    return command.name in CAREFUL or abs(command.numbers.get("distance_m", 0.0)) > FAR


@dataclass(frozen=True)
class Moment:
    """When an order begins [s]. While somebody speaks it is put off: they may be about to hold it back."""

    begins: float
    latest: float

    @classmethod
    def from_now(cls, now: float, length: float = MOMENT) -> Moment:
        """The moment of an order that was understood just now."""
        return cls(begins=now + length, latest=now + length + LONGEST)

    def while_speaking(self, now: float) -> Moment:
        """Somebody speaks now."""
        return replace(self, begins=min(max(self.begins, now + READING), self.latest))
