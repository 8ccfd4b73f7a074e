"""The worker that reads words out of sound: decoding would hold up everything else in the console's own process."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from console.workers.array_worker import array_in
from core.sensors.microphones import Sound
from core.speech.recognition.decision import RecognizedUtterance
from core.speech.recognition.engines import ActiveEngine, open_engine
from core.speech.recognition.recognizer import at_16_khz
from core.speech.recognition.rejected_commands import RejectedCommands
from core.speech.settings import SpeechSettings
from core.speech.transcription.array_transcriber import ArrayTranscriber
from core.speech.transcription.transcriber import Transcriber

Order = tuple[str, float]  # its words, and how long ago [s] it was rejected


class TranscriptionWorker:
    """Remembers the sound so far: pieces come in the order in which they were heard."""

    def __init__(self) -> None:
        self._transcriber: Transcriber | ArrayTranscriber | None = None
        self._engine: tuple[SpeechSettings, ActiveEngine] | None = None
        self._speaker = 0
        self._rejected = RejectedCommands()  # of this speaker's, by whichever transcriber heard it

    def begin(
        self, settings: dict[str, Any], held: bool = False, array: dict[str, Any] | None = None, speaker: int = 0
    ) -> str:
        """Listen again with the engine that the settings name; `held`: everything up to `finish` is one utterance.

        With an array the sound has a channel for each of its microphones, and the beam towards the voice is read; it
        listens all the time, so `held` says nothing there.
        What was rejected is forgotten when another `speaker` begins. Returns which engine reads the words, and why.
        Raises Unavailable and BadInput with a sentence.
        """
        if speaker != self._speaker:
            self._speaker, self._rejected = speaker, RejectedCommands()
        chosen = SpeechSettings(**settings)
        if self._engine is None or self._engine[0] != chosen:
            self._engine = chosen, open_engine(chosen)
        engine = self._engine[1]
        if array is None:
            self._transcriber = Transcriber(chosen, held=held, recognizer=engine.recognizer, rejected=self._rejected)
        else:
            in_order = array_in(array | {"channels": range(len(array["positions"])), "rate": None})
            self._transcriber = ArrayTranscriber(
                in_order, chosen, recognizer=engine.recognizer, rejected=self._rejected
            )
        return engine.why

    def feed(
        self, samples: bytes, rate: int, stamp: float, channels: int = 1, rejected: Sequence[Order] = ()
    ) -> list[RecognizedUtterance]:
        """32-bit numbers, channel by channel of each moment, first at `stamp` [s] → the utterances known with them.

        `rejected`: commands that were understood and then rejected, before the sound's end.
        """
        assert self._transcriber is not None
        numbers = np.frombuffer(samples, np.float32).astype(float).reshape(-1, channels)
        sound = at_16_khz(Sound(stamp=stamp, rate=rate, samples=numbers))
        for words, ago in rejected:
            self._rejected.reject(words, stamp + sound.duration - ago)
        return list(self._transcriber.feed(sound))

    def finish(self) -> list[RecognizedUtterance]:
        """End the sound → the utterances that became known with that."""
        assert self._transcriber is not None
        return list(self._transcriber.finish())
