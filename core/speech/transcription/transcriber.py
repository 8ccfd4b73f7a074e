"""Words out of sound as it comes: endpoints cut it, an engine reads each utterance, STOP is reported early."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from core.commands.stop_moving import STOP_MOVING
from core.sensors.microphones import Sound
from core.speech.recognition.acceptance import judge
from core.speech.recognition.endpointing import Endpointer, Held
from core.speech.recognition.engines import open_engine
from core.speech.recognition.recognizer import Engine, Utterance, WordHypothesis
from core.speech.recognition.rejected_commands import RejectedCommands
from core.speech.settings import SpeechSettings
from core.speech.sphinx.keyword_spotting import KeywordSpotter

LONGEST_EARLY = 5.0  # [s] of an utterance that is read in a pause; longer ones are no commands but talk


class Transcriber:
    """The recognizer of this project, for any engine."""

    def __init__(
        self,
        settings: SpeechSettings | None = None,
        *,
        held: bool = False,
        engine: Engine | None = None,
        rejected: RejectedCommands | None = None,
    ) -> None:
        """`held`: hold-to-talk, so the sound between two calls of `finish` is one utterance; else endpoints are
        sought. One engine may serve several transcribers in turn, and what one heard `rejected` the next may know.
        Raises Unavailable with a sentence.
        """
        chosen = settings or SpeechSettings()
        self._engine = engine or open_engine(chosen)
        self._spotter = KeywordSpotter(chosen)
        self._cutter = Held(chosen) if held else Endpointer(chosen)
        self._early: WordHypothesis | None = None
        self._rejected = RejectedCommands() if rejected is None else rejected

    @property
    def speaking_since(self) -> float | None:
        """Begin [s] of the utterance under way; None: there is none."""
        return self._cutter.speaking_since

    def feed(self, sound: Sound) -> tuple[WordHypothesis, ...]:
        """The next piece of sound → STOP at once, and the sentences that ended in it, as they were spoken: a long
        piece may hold a sentence and a STOP after it, which must not be overtaken. Raises BadInput.
        """
        stops = list(self._spotter.feed(sound))
        ended = self._read(self._cutter.feed(sound))
        so_far = self._cutter.so_far
        if so_far is not None and not self._is_early(so_far) and so_far.end - so_far.begin < LONGEST_EARLY:
            self._early = self._words(so_far)
            if _stops(self._early):
                stops.append(replace(self._early, final=False))
        return self._remembered(sorted((*stops, *ended), key=lambda heard: heard.end))

    def finish(self) -> tuple[WordHypothesis, ...]:
        """The sound ends here → the sentence that was under way."""
        return self._remembered(self._read(self._cutter.finish()))

    def _remembered(self, heard: Iterable[WordHypothesis]) -> tuple[WordHypothesis, ...]:
        """Remember what was heard, for later rejections, and return it."""
        hypotheses = tuple(heard)
        for one in hypotheses:
            self._rejected.hear(one)
        return hypotheses

    def _read(self, utterances: tuple[Utterance, ...]) -> tuple[WordHypothesis, ...]:
        """Utterances that ended → what was said in them, as read in their last pause where that was the end."""
        return tuple(
            self._early if self._early is not None and self._is_early(one) else self._words(one) for one in utterances
        )

    def _words(self, utterance: Utterance) -> WordHypothesis:
        return self._engine.read(replace(utterance, rejected=self._rejected.words(utterance.begin)))

    def _is_early(self, utterance: Utterance) -> bool:
        """Return whether the utterance was read in its last pause, and nothing was said since."""
        return self._early is not None and (self._early.begin, self._early.end) == (utterance.begin, utterance.end)


def _stops(heard: WordHypothesis) -> bool:
    """Return whether the words read in a pause stop the robot: STOP does not wait for the end of the sentence."""
    command = judge(heard).command
    return command is not None and command.name == STOP_MOVING.name
