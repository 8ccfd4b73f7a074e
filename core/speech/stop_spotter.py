"""STOP, heard in whatever is said, before the sentence is over. Rather once too often than once too late.

So willingly that the motors' own hum would pass for it where it sets in; but a hum stays as loud as it began, and a
word falls between its sounds.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from core.message import Array
from core.sensors.microphones import Sound, joined
from core.speech.endpointing import SILENT
from core.speech.pocketsphinx import FRAME, decoder, take_in
from core.speech.recognizer import Hypothesis, checked
from core.speech.settings import RATE, SpeechSettings

WORD = "stop"
RENEWAL = 20.0  # [s] after which the spotter begins anew, so that it remembers no more than that
LONGEST = 0.8  # [s] of the word; what is longer is the noise in which a decoder has just begun
BLOCK = 0.05  # [s] of which loudness is told
LEAST_FALL = 4.5  # [dB] below what was loudest until then, that a word falls: STOP 6 and more, a hum 3 and less
AFTER = 0.25  # [s] behind the word in which it may fall: its end is found early
GAP = 0.02  # [s] missing between two pieces of sound, beyond which spotting begins anew


class StopSpotter:
    """Listens to all sound for one word, apart from any grammar, and tells it from sound that is still going on."""

    def __init__(self, settings: SpeechSettings | None = None) -> None:
        """Raises Unavailable when pocketsphinx is not installed."""
        chosen = settings or SpeechSettings()
        self._decoder = decoder(keyphrase=WORD, kws_threshold=chosen.stop_threshold, kws_delay=chosen.stop_delay)
        self._decoder.start_utt()
        self._start = 0.0
        self._heard = 0
        self._newest: Sound | None = None  # as much of it as a word lasts

    def feed(self, sound: Sound) -> tuple[Hypothesis, ...]:
        """The next piece of sound → STOP, if it was in there. Raises BadInput."""
        samples = checked(sound)
        if abs(sound.stamp - self._now) > GAP:
            self._renew(sound.stamp)
        take_in(self._decoder, samples)
        self._heard += len(samples)
        self._newest = newest = joined(self._newest, sound, LONGEST + AFTER) or sound
        words = spotted(self._decoder, self._start)
        found = tuple(one for one in words if not hums(one, newest))
        undecided = not found and any(self._now - one.end < AFTER for one in words)
        if (self._decoder.hyp() is not None and not undecided) or self._heard > RENEWAL * RATE:
            self._renew(self._now)
        return found

    @property
    def _now(self) -> float:
        return self._start + self._heard / RATE

    def _renew(self, now: float) -> None:
        self._decoder.end_utt()
        self._decoder.start_utt()
        self._start, self._heard = now, 0


def spotted(decoder: Any, start: float) -> tuple[Hypothesis, ...]:
    """What a decoder that spots one word found in sound from `start` [s] on: STOP, or nothing as short as that."""
    found = list(decoder.seg() or ()) if decoder.hyp() is not None else []
    if not found or FRAME * (found[-1].end_frame + 1 - found[-1].start_frame) > LONGEST:
        return ()
    begin, end = (start + FRAME * frame for frame in (found[-1].start_frame, found[-1].end_frame + 1))
    return (Hypothesis(words=WORD, begin=begin, end=end, final=False),)


def hums(word: Hypothesis, sound: Sound) -> bool:
    """Whether what was taken for a word, in the first channel of the sound, is as steady as no word is."""
    return fall(sound.part(word.begin, word.end + AFTER).samples[:, 0], sound.rate) < LEAST_FALL


def fall(samples: Array, rate: int) -> float:
    """Samples (N,) → by how much [dB] they become fainter, at most, than they had been; 0 where they only rise."""
    size = round(BLOCK * rate)
    blocks = samples[: len(samples) // size * size].reshape(-1, size)
    if not len(blocks):
        return 0.0
    level = 10 * np.log10(np.mean(blocks**2, axis=1) + SILENT)
    return float(np.max(np.maximum.accumulate(level) - level))
