"""The start of spoken commands: soon after the words; some wait for a delay in which STOP cancels them."""

from dataclasses import dataclass, replace
from typing import Self

MAX_OBEYED_AGE_S = 2.0  # after their end at which a spoken command may still start
CONFIRMATION_DELAY_S = 2.0
RECOGNITION_TIME_S = 1.2  # after a person spoke, in which their STOP can have been recognised
MAX_POSTPONED_S = 4.0  # by which a room that never falls silent postpones a command


@dataclass(frozen=True)
class ConfirmationDelay:
    """Start time of a command [s]. While a person speaks it is postponed: they may be about to cancel it."""

    begins: float
    latest: float

    @classmethod
    def from_now(cls, now: float, length: float = CONFIRMATION_DELAY_S) -> Self:
        """Return the delay of a command that was understood just now."""
        return cls(begins=now + length, latest=now + length + MAX_POSTPONED_S)

    def while_speaking(self, now: float) -> Self:
        """Return the delay while a person speaks at `now` [s]."""
        return replace(self, begins=min(max(self.begins, now + RECOGNITION_TIME_S), self.latest))
