"""STOP within an utterance: obeyed at once and once, and nothing else that was said with it moves the robot."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

from console.control.command_freshness import CommandFreshness, Spoken
from core.commands.stop_at import STOP_AT
from core.speech.recognition.decision import RecognizedUtterance, stop
from core.speech.settings import PIECE

SAME = 1.0  # [s] by which the whole sentence may place the STOP later than it was first heard


def stopped(utterance: RecognizedUtterance) -> RecognizedUtterance:
    """Return the utterance as one whose STOP was obeyed, whatever was decided about the rest."""
    return replace(utterance, decision=stop(utterance.decision.words))


class SpokenStops:
    """The stops of one listener. All times are those of the sound's own clock [s]."""

    def __init__(self) -> None:
        self._end = -math.inf  # [s] of the newest STOP that was heard
        self._utterance = object()  # in which it was

    def another_clock(self) -> None:
        """The sound that comes from now on has other times."""
        self._end = -math.inf

    def hear(self, utterance: RecognizedUtterance) -> Literal["words", "stop", "stopped"]:
        """Words without a STOP, a STOP that is to be obeyed, or the rest of an utterance whose STOP was obeyed.

        The whole sentence "stop at x and y" is a command, although the robot stops as soon as it hears its beginning.
        """
        same = utterance.begin <= self._end
        if utterance.decision.stops:
            if utterance.end <= self._end + (SAME if utterance.final and same else PIECE):
                return "stopped"
            if not same:
                self._utterance = object()
            self._end = utterance.end
            return "stop"
        command = utterance.decision.command
        at_place = command is not None and command.name == STOP_AT.name
        return "stopped" if same and not at_place else "words"

    def obeyed(self, words: CommandFreshness) -> None:
        """The newest stop of all is the one that was heard here."""
        words.stopped_by(self._utterance)

    def said(self, begin: float, said: Spoken) -> Spoken:
        """When words that began at `begin` [s] were said; their own STOP does not make them void."""
        return replace(said, utterance=self._utterance) if begin <= self._end else said
