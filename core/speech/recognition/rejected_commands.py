"""Rejected commands: a person who speaks again most likely did not mean what was heard the first time.

A sentence that a recognizer mishears it often mishears again, from the same place by the same voice. The STOP that
follows it, or Cancel, adds what the sound lacks: such a negative confirmation makes the same reading less likely.
"""

from core.speech.recognition.decision import RecognizedUtterance

OBJECTION_TIME_S = 5.0  # after a sentence in which a STOP rejects it: it is read, said back, and waits meanwhile
REJECTION_MEMORY_S = 30.0  # after that


class RejectedCommands:
    """Observes every understood command."""

    def __init__(self) -> None:
        self._newest: RecognizedUtterance | None = None  # the newest command, while it is pending
        self._stopped: dict[str, float] = {}  # rejected words, and when [s]

    def hear(self, heard: RecognizedUtterance) -> None:
        """Note what was decided."""
        if heard.decision.command is None:
            return
        if not heard.decision.stops:
            self._newest = heard if heard.decision.waits else None
        elif self._newest is not None:
            if 0 <= heard.end - self._newest.end < OBJECTION_TIME_S:
                self._stopped[self._newest.decision.words] = heard.end
            self._newest = None

    def reject(self, words: str, now: float) -> None:
        """Note that a pending command was rejected by Cancel or by a button."""
        self._stopped[words] = now

    def words(self, now: float) -> tuple[str, ...]:
        """The sentences that were rejected not long before `now` [s], where an utterance began."""
        self._stopped = {words: then for words, then in self._stopped.items() if abs(now - then) < REJECTION_MEMORY_S}
        return tuple(words for words, then in self._stopped.items() if then <= now)
