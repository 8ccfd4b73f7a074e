"""The start of spoken commands: soon after the words; some wait for a delay in which STOP cancels them."""

from __future__ import annotations

from dataclasses import dataclass, replace

OBEYED_WITHIN = 2.0  # [s] after their end at which a spoken command may still start
DELAY = 2.0  # [s]
READING = 1.2  # [s] after a person spoke, in which their STOP can have been recognised
LONGEST = 4.0  # [s] by which a room that never falls silent postpones a command


@dataclass(frozen=True)
class ConfirmationDelay:
    """Start time of a command [s]. While a person speaks it is postponed: they may be about to cancel it."""

    begins: float
    latest: float

    @classmethod
    def from_now(cls, now: float, length: float = DELAY) -> ConfirmationDelay:
        """Return the delay of a command that was understood just now."""
        return cls(begins=now + length, latest=now + length + LONGEST)

    def while_speaking(self, now: float) -> ConfirmationDelay:
        """Return the delay while a person speaks at `now` [s]."""
        return replace(self, begins=min(max(self.begins, now + READING), self.latest))
