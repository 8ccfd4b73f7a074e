"""STOP, heard in the beam towards whoever speaks where noise covers one microphone: the robot drives, and hums.

Beside its own motors the robot hears 0 to 7 dB of a voice two metres away; there `StopSpotter` is deaf. The beam and
Wiener's filter give back enough to spot the one word, more willingly than in quiet, and before the sentence is over.
"""

from __future__ import annotations

from core.perception.sound.wiener import without_noise
from core.sensors.microphones import Sound
from core.speech.endpointing import over_noise
from core.speech.pocketsphinx import decoder, take_in
from core.speech.recognizer import Hypothesis
from core.speech.settings import SpeechSettings
from core.speech.stop_spotter import WORD, hums, spotted

LONGEST = 3.0  # [s] of an utterance under way that is still listened to: STOP is a short one
UNSURE = 0.15  # [s] before the first voiced moment that are not taken for noise: the voice may begin there


class StopInNoise:
    """Listens to the beam of an utterance under way, again with every piece of sound, and tells STOP once."""

    def __init__(self, settings: SpeechSettings) -> None:
        """Raises Unavailable when pocketsphinx is not installed."""
        self._ratio = 10 ** (settings.covered_ratio / 10)
        self._decoder = decoder(keyphrase=WORD, kws_threshold=settings.stop_in_noise, kws_delay=settings.stop_delay)
        self._told: float | None = None  # [s] first voiced moment of the utterance whose STOP was told

    def wants(self, since: float, now: float) -> bool:
        """Whether an utterance that began at `since` [s] may still hold a STOP that is not told."""
        return since != self._told and now - since <= LONGEST

    def find(self, beam: Sound, since: float) -> tuple[Hypothesis, ...]:
        """One channel from before the utterance up to now, first voiced at `since` [s] → STOP, if noise covers it."""
        samples, before = beam.samples[:, 0], round((since - UNSURE - beam.stamp) * beam.rate)
        if before <= 0 or over_noise(samples[before:], samples[:before]) > self._ratio:
            return ()
        self._decoder.start_utt()
        take_in(self._decoder, without_noise(samples, beam.rate, before), whole=True)
        self._decoder.end_utt()
        found = spotted(self._decoder, beam.stamp)
        if not found or hums(found[0], beam):
            return ()
        self._told = since
        return found
