"""Spot STOP with Whisper, where pocketsphinx is not installed: the newest sound is read again and again."""

import numpy as np

from core.message import Array
from core.sensors.microphones import Sound
from core.speech.recognition.decision import RecognizedUtterance, stop
from core.speech.recognition.loudness import Loudness
from core.speech.recognition.recognizer import checked
from core.speech.settings import RATE_HZ
from core.speech.understanding.grammar import STOP_WORD
from core.speech.whisper.recognizer import WhisperRecognizer

WINDOW_S = 1.2  # that are read at once: the word and what is around it
READING_STEP_S = 0.3  # between readings
MIN_RISE_DB = 6.0  # over the quietest tenth of the blocks, below which nobody speaks and nothing is read
MAX_GAP_S = 0.02  # missing between two pieces of sound, beyond which spotting starts again


class WhisperKeywordSpotter:
    """Reads the last second or so while someone speaks."""

    def __init__(self, recognizer: WhisperRecognizer) -> None:
        self._recognizer = recognizer
        self._forget(0.0)

    def feed(self, sound: Sound) -> tuple[RecognizedUtterance, ...]:
        """The next piece of sound → STOP, if it was in there. Raises BadInput."""
        samples = checked(sound)
        if abs(sound.stamp - self._until) > MAX_GAP_S:
            self._forget(sound.stamp)
        self._until += len(samples) / RATE_HZ
        self._newest = np.concatenate((self._newest, samples))[-round(WINDOW_S * RATE_HZ) :]
        self._loudness.add(samples)
        if self._until - self._read < READING_STEP_S or self._loudness.rise(2 * READING_STEP_S) < MIN_RISE_DB:
            return ()
        self._read = self._until
        window = self._newest
        texts = self._recognizer.search(window).free
        if not texts or not STOP_WORD.search(texts[0].text.lower()):
            return ()
        begin, end = self._until - len(window) / RATE_HZ, self._until
        self._newest = np.zeros(0)
        return (RecognizedUtterance(begin=begin, end=end, decision=stop(), final=False),)

    def _forget(self, now: float) -> None:
        self._newest: Array = np.zeros(0)
        self._loudness = Loudness()
        self._until = self._read = now
