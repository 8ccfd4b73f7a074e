"""STOP where noise covers the voice, and noise that is no STOP."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from core.message import Array
from core.sensors.microphones import Sound
from core.speech.recognition.decision import RecognizedUtterance, stop
from core.speech.recognition.recognizer import at_16_khz
from core.speech.settings import RATE_HZ, SpeechSettings
from core.speech.sphinx.keyword_spotting import MAX_UNDER_WAY_S, BeamformedStop, SphinxKeywordSpotter, fall, spotted
from core.speech.synthesis import PERSONS_VOICE, VoiceSettings, can_speak, speak
from tests.core.speech.ears import mono

pytest.importorskip("pocketsphinx", reason="Recognising words needs pocketsphinx: pip install pocketsphinx")
SINCE = 0.6  # [s]


def in_hum(words: str, decibels: float) -> Sound:
    """Words over a hum like that of motors, that is there before them."""
    voice = at_16_khz(speak(words, VoiceSettings(voice=PERSONS_VOICE, speed=140))).samples[:, 0]
    voice = np.trim_zeros(voice)
    samples = hum(np.random.default_rng(5), SINCE + len(voice) / RATE_HZ + 0.1)
    gain = 10 ** (decibels / 20) * samples.std() / voice.std()
    samples[round(SINCE * RATE_HZ) :][: len(voice)] += gain * voice
    return mono(samples)


def hum(rng: np.random.Generator, seconds: float) -> Array:
    noise = rng.normal(size=round(seconds * RATE_HZ))
    spectrum = np.fft.rfft(noise) / np.sqrt(1 + np.arange(len(noise) // 2 + 1) / 100)
    return 0.02 * np.fft.irfft(spectrum, len(noise))


@pytest.mark.skipif(not can_speak(), reason="nothing here speaks: pip install espeakng-loader")
def test_stop_is_heard_in_a_hum_and_other_words_are_not_stop() -> None:
    spotter = BeamformedStop(SpeechSettings())
    (told,) = spotter.find(in_hum("stop moving", 8.0), SINCE)
    assert told.decision.stops and not told.final
    assert SINCE - 0.1 < told.begin < told.end < SINCE + 0.8
    assert spotter.find(in_hum("turn left", 8.0), SINCE) == ()
    assert spotter.find(mono(hum(np.random.default_rng(6), 1.5)), SINCE) == ()


class Counting(SphinxKeywordSpotter):
    """A spotter that counts how often it begins to decode."""

    began = 0

    def _renew(self, now: float) -> None:
        self.began += 1
        super()._renew(now)


@pytest.mark.skipif(not can_speak(), reason="nothing here speaks: pip install espeakng-loader")
def test_nothing_is_decoded_while_nobody_speaks_and_stop_is_heard_after_a_long_silence() -> None:
    quiet = 1e-3 * np.random.default_rng(0).normal(size=30 * RATE_HZ)
    voice = at_16_khz(speak("stop moving", VoiceSettings(voice=PERSONS_VOICE))).samples[:, 0]
    spotter = Counting()
    told = [one for piece in mono(quiet).pieces(0.1) for one in spotter.feed(piece)]
    assert not told and spotter.began == 0
    sound = mono(np.concatenate((0.3 * voice, quiet[:RATE_HZ])), 30.0)
    (word,) = [one for piece in sound.pieces(0.1) for one in spotter.feed(piece)]
    assert word.decision.stops and 30.0 < word.end < 31.0


def test_an_utterance_is_told_to_stop_once_and_long_talk_is_not_listened_to() -> None:
    spotter = BeamformedStop(SpeechSettings())
    assert spotter.wants(1.0, 1.5)
    assert not spotter.wants(1.0, 1.0 + MAX_UNDER_WAY_S + 0.1)
    if can_speak():
        assert spotter.find(in_hum("stop moving", 8.0), SINCE)
        assert not spotter.wants(SINCE, SINCE + 0.5)
        assert spotter.wants(SINCE + 5.0, SINCE + 5.5)
        assert spotter.wants(SINCE - 0.5, SINCE)  # another clock: the robot was started anew


def test_a_hum_that_sets_in_is_no_word_however_willingly_one_is_spotted(monkeypatch: pytest.MonkeyPatch) -> None:
    told = RecognizedUtterance(begin=SINCE, end=SINCE + 0.5, decision=stop(), final=False)
    monkeypatch.setattr("core.speech.sphinx.keyword_spotting.spotted", lambda *_: (told,))
    anything = BeamformedStop(SpeechSettings())
    rng = np.random.default_rng(7)
    samples = hum(rng, 2.0)
    samples[: round(SINCE * RATE_HZ)] *= 10 ** (-15 / 20)
    assert anything.find(mono(samples), SINCE) == ()
    if can_speak():
        assert anything.find(in_hum("stop moving", 3.0), SINCE)


def test_the_spotter_of_all_sound_takes_no_hum_for_a_word() -> None:
    anything = SphinxKeywordSpotter(SpeechSettings(stop_threshold=1e-200))
    noise = hum(np.random.default_rng(8), 6.0)
    noise[: 3 * RATE_HZ] *= 0.1
    assert not any(anything.feed(mono(noise[k : k + 3200], k / RATE_HZ)) for k in range(0, len(noise), 3200))
    if can_speak():
        assert anything.feed(in_hum("stop moving", 25.0))


def test_how_far_sound_falls_below_what_was_loudest_until_then() -> None:
    tone = np.sin(np.arange(RATE_HZ) * 0.7)
    assert fall(tone, RATE_HZ) < 0.5
    rising = np.concatenate((0.1 * tone, tone))
    assert fall(rising, RATE_HZ) < 0.5
    assert fall(rising[::-1], RATE_HZ) == pytest.approx(20.0, abs=0.5)
    assert fall(tone[:100], RATE_HZ) == 0.0


@dataclass
class Found:
    """A decoder that spotted its word between two frames."""

    start_frame: int
    end_frame: int

    def hyp(self) -> str:
        return "stop"

    def seg(self) -> list[Found]:
        return [self]


def test_a_decoder_that_has_just_begun_to_hear_a_hum_finds_its_word_at_a_length_that_no_word_has() -> None:
    assert spotted(Found(10, 189), 3.0) == ()
    (told,) = spotted(Found(10, 49), 3.0)
    assert (told.begin, told.end) == pytest.approx((3.1, 3.5))
