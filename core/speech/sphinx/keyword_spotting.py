"""Spot STOP in running speech, before the sentence is over. One false alarm is better than one late stop.

Without pocketsphinx `core/speech/whisper/keyword_spotting.py` does it; `core/speech/recognition/engines.py` chooses.

The threshold is so low that the start of the motors' hum would pass for it. But a hum stays as loud as it began, and
a word becomes fainter between its sounds.
"""

import math
from typing import Any

import numpy as np

from core.message import Array
from core.perception.sound.noise_reduction import without_noise
from core.sensors.microphones import Sound, joined
from core.speech.recognition.decision import RecognizedUtterance, stop
from core.speech.recognition.endpointing import SILENT_POWER, over_noise
from core.speech.recognition.loudness import Loudness
from core.speech.recognition.recognizer import checked
from core.speech.settings import RATE_HZ, SpeechSettings
from core.speech.sphinx.decoder import FRAME_S, keyword_decoder, take_in

WORD, PHONES = "stop", "S T AA P"  # as in the CMU dictionary
RENEWAL_S = 20.0  # after which the spotter is restarted, so that it remembers no more than that
MAX_WORD_S = 0.8  # of the word; what is longer is the noise in which a decoder has just begun
BLOCK_S = 0.05  # over which loudness is computed
MIN_FALL_DB = 4.5  # below what was loudest until then, that a word falls: STOP 6 and more, a hum 3 and less
AFTER_WORD_S = 0.25  # behind the word in which it may fall: its end is found early
MIN_RISE_DB = 2.0  # over the quietest tenth of the newest sound, below which nobody speaks and nothing is decoded
OPEN_TIME_S = 1.2  # after such a rise in which all sound is decoded
BEFORE_RISE_S = 0.4  # before it that are decoded too
MAX_GAP_S = 0.02  # missing between two pieces of sound, beyond which spotting starts again


class SphinxKeywordSpotter:
    """Spots one word in all sound, apart from any grammar, before the sound has ended."""

    def __init__(self, settings: SpeechSettings | None = None) -> None:
        """Raises Unavailable when pocketsphinx is not installed."""
        chosen = settings or SpeechSettings()
        self._decoder = keyword_decoder(WORD, PHONES, chosen.stop_threshold, chosen.stop_delay)
        self._decoder.start_utt()
        self._start = 0.0
        self._heard = 0
        self._newest: Sound | None = None  # as much of it as a word lasts
        self._loudness = Loudness()
        self._decoding = False

    def feed(self, sound: Sound) -> tuple[RecognizedUtterance, ...]:
        """The next piece of sound → STOP, if it was in there. Raises BadInput."""
        samples = checked(sound)
        if abs(sound.stamp - self._now) > MAX_GAP_S:
            self._renew(sound.stamp)
            self._loudness, self._decoding = Loudness(), False
        self._newest = newest = joined(self._newest, sound, max(MAX_WORD_S + AFTER_WORD_S, sound.duration)) or sound
        self._loudness.add(samples)
        before, self._decoding = self._decoding, self._loudness.rise(OPEN_TIME_S + sound.duration) > MIN_RISE_DB
        if not self._decoding:
            self._heard += len(samples)
            return ()
        if not before:
            since = max(self._now - BEFORE_RISE_S, newest.stamp)
            samples = newest.part(since, newest.stamp + newest.duration).samples[:, 0]
            self._renew(since)
        take_in(self._decoder, samples)
        self._heard += len(samples)
        words = spotted(self._decoder, self._start)
        found = tuple(one for one in words if not hums(one, newest))
        undecided = not found and any(self._now - one.end < AFTER_WORD_S for one in words)
        if (self._decoder.hyp() is not None and not undecided) or self._heard > RENEWAL_S * RATE_HZ:
            self._renew(self._now)
        return found

    @property
    def _now(self) -> float:
        return self._start + self._heard / RATE_HZ

    def _renew(self, now: float) -> None:
        self._decoder.end_utt()
        self._decoder.start_utt()
        self._start, self._heard = now, 0


def spotted(decoder: Any, start: float) -> tuple[RecognizedUtterance, ...]:
    """Return the word that a decoder spotted in sound from `start` [s] on: STOP, or nothing as short as that."""
    found = list(decoder.seg() or ()) if decoder.hyp() is not None else []
    if not found or FRAME_S * (found[-1].end_frame + 1 - found[-1].start_frame) > MAX_WORD_S:
        return ()
    begin, end = (start + FRAME_S * frame for frame in (found[-1].start_frame, found[-1].end_frame + 1))
    return (RecognizedUtterance(begin=begin, end=end, decision=stop(), final=False),)


def hums(word: RecognizedUtterance, sound: Sound) -> bool:
    """Return whether a spotted "word", in the first channel of the sound, is too steady to be a word."""
    return fall(sound.part(word.begin, word.end + AFTER_WORD_S).samples[:, 0], sound.rate) < MIN_FALL_DB


def fall(samples: Array, rate: int) -> float:
    """Samples (N,) → by how much [dB] they become fainter, at most, than they had been; 0 where they only rise."""
    size = round(BLOCK_S * rate)
    blocks = samples[: len(samples) // size * size].reshape(-1, size)
    if not len(blocks):
        return 0.0
    level = 10 * np.log10(np.mean(blocks**2, axis=1) + SILENT_POWER)
    return float(np.max(np.maximum.accumulate(level) - level))


LISTEN_PERIOD_S = 0.09  # between two times that an utterance under way is listened to, at least
MAX_UNDER_WAY_S = 3.0  # of an utterance under way that is still listened to: STOP is a short one
UNCLEAR_TIME_S = 0.15  # before the first voiced moment that are not taken for noise: the voice may begin there


class BeamformedStop:
    """Listens to the beam of an utterance under way, again and again while it lasts, and reports STOP once."""

    def __init__(self, settings: SpeechSettings) -> None:
        """Raises Unavailable when pocketsphinx is not installed."""
        self._ratio = 10 ** (settings.covered_ratio / 10)
        self._decoder = keyword_decoder(WORD, PHONES, settings.stop_in_noise, settings.stop_delay)
        self._reported: float | None = None  # [s] first voiced moment of the utterance whose STOP was reported
        self._listened = -math.inf  # [s] until when

    def wants(self, since: float, now: float) -> bool:
        """Return whether an utterance that began at `since` [s] may still hold an unreported STOP."""
        due = not 0 <= now - self._listened < LISTEN_PERIOD_S  # a clock may begin again
        return due and since != self._reported and now - since <= MAX_UNDER_WAY_S

    def find(self, beam: Sound, since: float) -> tuple[RecognizedUtterance, ...]:
        """One channel from before the utterance up to now, first voiced at `since` [s] → STOP, if noise covers it."""
        self._listened = beam.stamp + beam.duration
        samples, before = beam.samples[:, 0], round((since - UNCLEAR_TIME_S - beam.stamp) * beam.rate)
        if before <= 0 or over_noise(samples[before:], samples[:before]) > self._ratio:
            return ()
        self._decoder.start_utt()
        take_in(self._decoder, without_noise(samples, beam.rate, before), whole=True)
        self._decoder.end_utt()
        found = spotted(self._decoder, beam.stamp)
        if not found or hums(found[0], beam):
            return ()
        self._reported = since
        return found
