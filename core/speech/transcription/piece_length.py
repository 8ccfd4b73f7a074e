"""How much sound of a room is read at once: little while someone speaks, more while nobody does, which costs less."""

import math

from core.speech.settings import PIECE_S, VOICE_PIECE_S

AFTER_VOICE_S = 1.0  # behind a voice, within which its sentence may still be read


class PieceLength:
    """Follows one room's clock [s]."""

    def __init__(self) -> None:
        self.seconds = PIECE_S  # [s] of sound that are read at once, at least
        self._spoke = -math.inf

    def follow(self, now: float, speaking: bool) -> None:
        """It is `now`; `speaking`: an utterance is under way."""
        if speaking or now < self._spoke:  # or another clock
            self._spoke = now if speaking else -math.inf
        self.seconds = VOICE_PIECE_S if now - self._spoke <= AFTER_VOICE_S else PIECE_S
