"""The worker that reads words out of sound: decoding would hold up everything else in the console's own process."""

from __future__ import annotations

from typing import Any

import numpy as np

from core.sensors.microphones import Sound
from core.speech.engines import open_engine
from core.speech.recognizer import Engine, for_words
from core.speech.settings import SpeechSettings
from core.speech.spoken import Spoken, judge
from core.speech.transcriber import Transcriber


class WordsDesk:
    """Remembers the sound so far: pieces come in the order in which they were heard."""

    def __init__(self) -> None:
        self._transcriber: Transcriber | None = None
        self._engine: tuple[SpeechSettings, Engine] | None = None

    def begin(self, settings: dict[str, Any], held: bool = False) -> bool:
        """Listen anew with the engine that the settings name; `held`: everything up to `finish` is one utterance.

        Raises Unavailable and BadInput with a sentence.
        """
        chosen = SpeechSettings(**settings)
        if self._engine is None or self._engine[0] != chosen:
            self._engine = chosen, open_engine(chosen)
        self._transcriber = Transcriber(chosen, held=held, engine=self._engine[1])
        return True

    def feed(self, samples: bytes, rate: int, stamp: float) -> list[dict[str, Any]]:
        """One channel of 32-bit numbers, first at `stamp` [s] → what became known with it."""
        assert self._transcriber is not None
        numbers = np.frombuffer(samples, np.float32).astype(float)
        sound = for_words(Sound(stamp=stamp, rate=rate, samples=numbers[:, None]))
        return [told(judge(heard)) for heard in self._transcriber.feed(sound)]

    def finish(self) -> list[dict[str, Any]]:
        """The sound ends here → what became known with that."""
        assert self._transcriber is not None
        return [told(judge(heard)) for heard in self._transcriber.finish()]


def told(said: Spoken) -> dict[str, Any]:
    """An utterance in plain values."""
    command = said.command
    return {
        "begin": said.begin,
        "end": said.end,
        "words": said.words,
        "final": said.final,
        "name": None if command is None else command.name,
        "numbers": {} if command is None else dict(command.numbers),
        "heard_as": "" if command is None else command.heard_as,
        "reason": said.reason,
        "suggestions": list(said.suggestions),
    }
