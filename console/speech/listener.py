"""The way of the words of one source: STOP at once, a command to the dispatcher, the rest into the history.

This is the one way from a recognizer's decision to the dispatcher: a page's microphone and the robot's own ears
differ in who speaks, and in what holds their words back.
"""

import math
from dataclasses import dataclass, replace
from typing import Literal

from console.access.logins import Person
from console.control.command_freshness import CommandFreshness, Spoken
from console.control.dispatcher import CommandDispatcher
from console.control.history import History
from console.control.history_store import HistoryEntry
from console.control.pending_commands import PendingCommand, PendingCommands
from console.http.problems import Problem
from console.messages import audio
from core.commands.stop_at import STOP_AT
from core.sentences import Statement, code_of
from core.speech.recognition.decision import Decision, RecognizedUtterance, stop
from core.speech.settings import PIECE_S

Heard = Literal["words", "stop", "stopped"]
"""Words without a STOP, a STOP that is to be obeyed, or the rest of an utterance whose STOP was obeyed."""
BESIDE_STOP = Statement("speech.beside_stop")
SAME_STOP_S = 1.0  # by which the whole sentence may place the STOP later than it was first heard


class SpokenStops:
    """STOP within utterances is obeyed at once and once, and nothing else that was said with it moves the robot.

    All times are those of the sound's own clock [s].
    """

    def __init__(self) -> None:
        self._end = -math.inf  # [s] of the newest STOP that was heard
        self._utterance = object()  # in which it was

    def reset(self) -> None:
        """The sound that comes from now on has other times."""
        self._end = -math.inf

    def hear(self, utterance: RecognizedUtterance) -> Heard:
        """Return what an utterance is beside those before it.

        The whole sentence "stop at x and y" is a command, although the robot stops as soon as it hears its beginning.
        """
        same = utterance.begin <= self._end
        if utterance.decision.stops:
            if utterance.end <= self._end + (SAME_STOP_S if utterance.final and same else PIECE_S):
                return "stopped"
            if not same:
                self._utterance = object()
            self._end = utterance.end
            return "stop"
        command = utterance.decision.command
        at_place = command is not None and command.name == STOP_AT.name
        return "stopped" if same and not at_place else "words"

    def obeyed(self, freshness: CommandFreshness) -> None:
        """The newest stop of all is the one that was heard here."""
        freshness.stopped_by(self._utterance)

    def said(self, begin: float, said: Spoken) -> Spoken:
        """When words that began at `begin` [s] were said; their own STOP does not make them void."""
        return replace(said, utterance=self._utterance) if begin <= self._end else said


@dataclass(frozen=True)
class SpokenOutcome:
    utterance: RecognizedUtterance  # as it counts: what was said beside an obeyed STOP is that STOP
    said: Spoken
    reason: str = ""  # why nothing is done about it, a sentence
    entry: int | None = None  # its row in the history
    pending_command: int | None = None
    heard: Heard = "words"

    def transcript(self, number: int, delay: float) -> audio.Transcript:
        """The utterance as its page shows it; `delay` [s] since the end of its sound."""
        utterance, decision, command = self.utterance, self.utterance.decision, self.utterance.decision.command
        return audio.Transcript(
            id=number,
            words=decision.words,
            final=utterance.final,
            accepted=command is not None and not self.reason,
            heard_as="" if command is None else command.heard_as,
            reason=self.reason,
            suggestions=list(decision.did_you_mean),
            confidence=round(decision.confidence, 3),
            seconds=round(utterance.end - utterance.begin, 2),
            delay_s=round(delay, 3),
            entry=self.entry,
            pending_command=self.pending_command,
            **code_of(self.reason)._asdict(),
        )


class WordListener:
    """Hears the words of one source. Lives on the event loop."""

    def __init__(
        self,
        source: str,
        speaker: Person,
        pending_commands: PendingCommands,
        dispatcher: CommandDispatcher,
        history: History,
    ) -> None:
        self.speaker = speaker  # in whose name words are written down, and obeyed
        self._source, self._pending_commands = source, pending_commands
        self._dispatcher, self._history = dispatcher, history
        self._stops = SpokenStops()
        self._newest_unrecognized = 0  # id of its entry in the history

    def reset(self) -> None:
        """The sound that comes from now on has other times."""
        self._stops.reset()

    def hear(self, utterance: RecognizedUtterance, ended: float, *, maybe_noise: bool = False) -> SpokenOutcome:
        """Act on an utterance, or on a STOP within one that is not over; `ended` [s]: when, by our own clock.

        `maybe_noise`: what has no words in it may be no voice, and is not written down.
        """
        heard = self._stops.hear(utterance)
        said = self._stops.said(utterance.begin, Spoken(ended - (utterance.end - utterance.begin), ended))
        if heard == "stop":
            entry = self._stop(utterance.decision, said)
            self._stops.obeyed(self._dispatcher.freshness)
            return SpokenOutcome(utterance, said, entry=entry, heard=heard)
        if heard == "stopped":
            return self._beside_stop(utterance, said)
        if utterance.decision.command is not None:
            return self._obey(utterance, said)
        return self._refuse(utterance, said, utterance.decision.reason, maybe_noise=maybe_noise)

    def _beside_stop(self, utterance: RecognizedUtterance, said: Spoken) -> SpokenOutcome:
        """Write down the words in which a STOP was obeyed that the whole sentence does not say: they move nothing."""
        lost = utterance.final and not utterance.decision.stops
        entry = self._refuse(utterance, said, BESIDE_STOP, maybe_noise=True).entry if lost else None
        stopped = replace(utterance, decision=stop(utterance.decision.words))  # whatever was decided about the rest
        return SpokenOutcome(stopped, said, entry=entry, heard="stopped")

    def _stop(self, decision: Decision, said: Spoken) -> int | None:
        try:
            return self._take(decision, said).id
        except Problem:  # the pilot did not take it; the robot stands all the same
            return None

    def _take(self, decision: Decision, said: Spoken) -> HistoryEntry | PendingCommand:
        return self._pending_commands.take(decision, self._source, self.speaker, said)

    def _obey(self, utterance: RecognizedUtterance, said: Spoken) -> SpokenOutcome:
        try:
            taken = self._take(utterance.decision, said)
        except Problem as problem:
            return SpokenOutcome(utterance, said, problem.detail)
        if isinstance(taken, PendingCommand):
            return SpokenOutcome(utterance, said, pending_command=taken.id)
        return SpokenOutcome(utterance, said, entry=taken.id)

    def _refuse(
        self, utterance: RecognizedUtterance, said: Spoken, reason: str, *, maybe_noise: bool = False
    ) -> SpokenOutcome:
        """Write down that words were not obeyed; talk without words is one entry until something else comes."""
        decision, newest = utterance.decision, self._history.newest_first(commands_only=True, limit=1)
        again = bool(newest) and newest[0].id == self._newest_unrecognized
        if not decision.words and (maybe_noise or again):
            return SpokenOutcome(utterance, said, reason)
        entry = self._history.add(
            "command",
            self.speaker,
            state="refused",
            source=self._source,
            words=decision.words,
            heard_as="" if decision.command is None else decision.command.heard_as,
            remark=reason,
        )
        if not decision.words:
            self._newest_unrecognized = entry.id
        return SpokenOutcome(utterance, said, reason, entry.id)
