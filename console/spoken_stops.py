"""STOP within an utterance: obeyed at once and once, and nothing else that was said with it moves the robot."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

from console.fresh_words import FreshWords, Said
from console.words_worker import Told
from core.commands.stand import STOP_MOVING
from core.commands.stop_at import STOP_AT
from core.speech.settings import PIECE

STOPPED: Told = {
    "name": STOP_MOVING.name,
    "heard_as": STOP_MOVING.words[0],
    "reason": "",
    "suggestions": [],
    "meant": "",
    "unsure": False,
}
"""What an utterance was understood as whose STOP was obeyed, whatever its rest was taken for."""
SAME = 1.0  # [s] by which the whole sentence may place the STOP later than it was first heard


class SpokenStops:
    """One listener's. Times of what it is given are those of the sound's own clock [s]."""

    def __init__(self) -> None:
        self._end = -math.inf  # [s] of the newest STOP that was heard
        self._utterance = object()  # in which it was

    def another_clock(self) -> None:
        """What comes from now on has other times."""
        self._end = -math.inf

    def hear(self, told: Told) -> Literal["words", "stop", "stopped"]:
        """Words without a STOP, a STOP that is to be obeyed, or the rest of an utterance whose STOP was obeyed.

        The whole sentence "stop at x and y" is a command, although the robot stops as soon as it hears its beginning.
        """
        same = told["begin"] <= self._end
        if told["name"] == STOP_MOVING.name:
            if told["end"] <= self._end + (SAME if told["final"] and same else PIECE):
                return "stopped"
            if not same:
                self._utterance = object()
            self._end = told["end"]
            return "stop"
        return "stopped" if same and told["name"] != STOP_AT.name else "words"

    def obeyed(self, words: FreshWords) -> None:
        """The newest stop of all is the one that was heard here."""
        words.stopped_by(self._utterance)

    def said(self, told: Told, said: Said) -> Said:
        """When words were said; their own STOP does not make them void."""
        return replace(said, utterance=self._utterance) if told["begin"] <= self._end else said
