"""Spot STOP with Whisper, where pocketsphinx is not installed: the newest sound is read again and again."""

from __future__ import annotations

import numpy as np

from core.message import Array
from core.sensors.microphones import Sound
from core.speech.recognition.decision import RecognizedUtterance, stop
from core.speech.recognition.recognizer import checked
from core.speech.settings import RATE
from core.speech.understanding.grammar import STOP_WORD
from core.speech.whisper.recognizer import WhisperRecognizer

WINDOW = 1.2  # [s] that are read at once: the word and what is around it
STEP = 0.3  # [s] between readings
BLOCK = 0.05  # [s] over which loudness is computed
REMEMBERED = 10.0  # [s] in which the quietest blocks are sought
LEAST_RISE = 6.0  # [dB] over the quietest tenth of the blocks, below which nobody speaks and nothing is read
SILENT = 1e-8  # power that counts as silence whatever the noise
GAP = 0.02  # [s] missing between two pieces of sound, beyond which spotting starts again


class WhisperKeywordSpotter:
    """Reads the last second or so while somebody speaks."""

    def __init__(self, recognizer: WhisperRecognizer) -> None:
        self._recognizer = recognizer
        self._forget(0.0)

    def feed(self, sound: Sound) -> tuple[RecognizedUtterance, ...]:
        """The next piece of sound → STOP, if it was in there. Raises BadInput."""
        samples = checked(sound)
        if abs(sound.stamp - self._until) > GAP:
            self._forget(sound.stamp)
        self._until += len(samples) / RATE
        self._newest = np.concatenate((self._newest, samples))[-round(REMEMBERED * RATE) :]
        if self._until - self._read < STEP or not self._voiced():
            return ()
        self._read = self._until
        window = self._newest[-round(WINDOW * RATE) :]
        texts = self._recognizer.search(window).free
        if not texts or not STOP_WORD.search(texts[0].text.lower()):
            return ()
        begin, end = self._until - len(window) / RATE, self._until
        self._forget(self._until)
        return (RecognizedUtterance(begin=begin, end=end, decision=stop(), final=False),)

    def _forget(self, now: float) -> None:
        self._newest: Array = np.zeros(0)
        self._until = self._read = now

    def _voiced(self) -> bool:
        """Return whether somebody may have spoken since the last reading."""
        size = round(BLOCK * RATE)
        whole = self._newest[len(self._newest) % size :].reshape(-1, size)
        if not len(whole):
            return False
        level = 10 * np.log10(np.mean(whole**2, axis=1) + SILENT)
        return float(level[-round(2 * STEP / BLOCK) :].max() - np.quantile(level, 0.1)) > LEAST_RISE
