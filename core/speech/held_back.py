"""Orders that were held back: who says hers again most likely did not mean what was heard the first time.

A sentence that a recognizer mishears it often mishears again, from the same place by the same voice. The STOP that
follows it, or Cancel, tells what the sound does not: such a negative confirmation makes the same reading less likely.
"""

from __future__ import annotations

from core.commands.careful import is_careful
from core.commands.stand import STOP_MOVING
from core.speech.recognizer import Hypothesis
from core.speech.spoken import judge

OBJECTED = 5.0  # [s] after a sentence in which a STOP holds it back: it is read, said back, and waits meanwhile
REMEMBERED = 30.0  # [s] after that


class HeldBack:
    """Listens to all that is understood."""

    def __init__(self) -> None:
        self._newest: Hypothesis | None = None  # the newest order, where it waits a moment
        self._stopped: dict[str, float] = {}  # words that were held back, and when [s]

    def hear(self, heard: Hypothesis) -> None:
        """What was understood."""
        spoken = judge(heard)
        if spoken.command is None:
            return
        if spoken.command.name != STOP_MOVING.name:
            self._newest = heard if spoken.unsure or is_careful(spoken.command) else None
        elif self._newest is not None:
            if 0 <= heard.end - self._newest.end < OBJECTED:
                self._stopped[self._newest.words] = heard.end
            self._newest = None

    def hold_back(self, words: str, now: float) -> None:
        """An order that waited was held back otherwise, by Cancel or by a button."""
        self._stopped[words] = now

    def words(self, now: float) -> tuple[str, ...]:
        """The sentences that were held back lately."""
        self._stopped = {words: then for words, then in self._stopped.items() if 0 <= now - then < REMEMBERED}
        return tuple(self._stopped)
