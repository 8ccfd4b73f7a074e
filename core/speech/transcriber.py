"""Words out of sound as it comes: endpoints cut it, an engine reads each utterance, STOP is told before its end."""

from __future__ import annotations

from core.sensors.microphones import Sound
from core.speech.endpointing import Endpointer, Held
from core.speech.engines import open_engine
from core.speech.recognizer import Engine, Hypothesis
from core.speech.settings import SpeechSettings
from core.speech.stop_spotter import StopSpotter


class Transcriber:
    """The recognizer of the house, whatever the engine."""

    def __init__(
        self, settings: SpeechSettings | None = None, *, held: bool = False, engine: Engine | None = None
    ) -> None:
        """`held`: hold-to-talk, so the sound between two calls of `finish` is one utterance; else endpoints are
        sought. One engine may serve several transcribers in turn. Raises Unavailable with a sentence.
        """
        chosen = settings or SpeechSettings()
        self._engine = engine or open_engine(chosen)
        self._spotter = StopSpotter(chosen)
        self._cutter = Held(chosen) if held else Endpointer(chosen)

    @property
    def speaking(self) -> bool:
        """Whether an utterance is under way."""
        return self._cutter.speaking

    def feed(self, sound: Sound) -> tuple[Hypothesis, ...]:
        """The next piece of sound → STOP at once, and the sentences that ended in it. Raises BadInput."""
        stops = self._spotter.feed(sound)
        return (*stops, *(self._engine.read(utterance) for utterance in self._cutter.feed(sound)))

    def finish(self) -> tuple[Hypothesis, ...]:
        """The sound ends here → the sentence that was under way."""
        return tuple(self._engine.read(utterance) for utterance in self._cutter.finish())
