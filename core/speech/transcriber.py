"""Words out of sound as it comes: endpoints cut it, an engine reads each utterance, STOP is told before its end."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from core.commands.stand import STOP_MOVING
from core.sensors.microphones import Sound
from core.speech.endpointing import Endpointer, Held
from core.speech.engines import open_engine
from core.speech.held_back import HeldBack
from core.speech.recognizer import Engine, Hypothesis, Utterance
from core.speech.settings import SpeechSettings
from core.speech.spoken import judge
from core.speech.stop_spotter import StopSpotter

LONGEST_EARLY = 5.0  # [s] of an utterance that is read in a pause; longer ones are no commands but talk


class Transcriber:
    """The recognizer of the house, whatever the engine."""

    def __init__(
        self,
        settings: SpeechSettings | None = None,
        *,
        held: bool = False,
        engine: Engine | None = None,
        held_back: HeldBack | None = None,
    ) -> None:
        """`held`: hold-to-talk, so the sound between two calls of `finish` is one utterance; else endpoints are
        sought. One engine may serve several transcribers in turn, and what one heard `held_back` the next may know.
        Raises Unavailable with a sentence.
        """
        chosen = settings or SpeechSettings()
        self._engine = engine or open_engine(chosen)
        self._spotter = StopSpotter(chosen)
        self._cutter = Held(chosen) if held else Endpointer(chosen)
        self._early: Hypothesis | None = None
        self._held_back = HeldBack() if held_back is None else held_back

    @property
    def speaking_since(self) -> float | None:
        """When [s] the utterance under way began; None: there is none."""
        return self._cutter.speaking_since

    def feed(self, sound: Sound) -> tuple[Hypothesis, ...]:
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
        return self._told(sorted((*stops, *ended), key=lambda heard: heard.end))

    def finish(self) -> tuple[Hypothesis, ...]:
        """The sound ends here → the sentence that was under way."""
        return self._told(self._read(self._cutter.finish()))

    def _told(self, heard: Iterable[Hypothesis]) -> tuple[Hypothesis, ...]:
        """What becomes known, remembered."""
        told = tuple(heard)
        for one in told:
            self._held_back.hear(one)
        return told

    def _read(self, utterances: tuple[Utterance, ...]) -> tuple[Hypothesis, ...]:
        """Utterances that ended → what was said in them, as read in their last pause where that was the end."""
        return tuple(
            self._early if self._early is not None and self._is_early(one) else self._words(one) for one in utterances
        )

    def _words(self, utterance: Utterance) -> Hypothesis:
        return self._engine.read(replace(utterance, held_back=self._held_back.words(utterance.begin)))

    def _is_early(self, utterance: Utterance) -> bool:
        """Whether the utterance has been read in its last pause, and nothing was said since."""
        return self._early is not None and (self._early.begin, self._early.end) == (utterance.begin, utterance.end)


def _stops(heard: Hypothesis) -> bool:
    """Whether what was read in a pause stops the robot: it need not wait until the sentence is over."""
    command = judge(heard).command
    return command is not None and command.name == STOP_MOVING.name
