"""Where utterances begin and end."""

import numpy as np
import pytest

from core.errors import BadInput
from core.sensors.microphones import Sound
from core.simulation.acoustics.shoebox import pink_noise
from core.speech.practice_voice import practice_voice
from core.speech.recognition.endpointing import Endpointer, Held
from core.speech.recognition.recognizer import Utterance, for_words
from core.speech.settings import RATE_HZ
from core.speech.sphinx.decoded_path import WordSpan
from core.speech.sphinx.recognizer import left_over
from tests.core.speech.ears import mono, padded, pieces


def said(*spans: tuple[float, float], length: float = 6.0, noise: float = 0.003, seed: int = 2) -> np.ndarray:
    """A voice of level 0.1 over the given times [s] in steady noise."""
    rng = np.random.default_rng(seed)
    samples = noise * pink_noise(rng, 1, int(length * RATE_HZ), RATE_HZ)[0]
    for begin, end in spans:
        voice = 0.1 * practice_voice(rng, end - begin, RATE_HZ)
        samples[round(begin * RATE_HZ) :][: len(voice)] += voice
    return samples


def cut(samples: np.ndarray, stamp: float = 0.0) -> list[Utterance]:
    ears = Endpointer()
    found = [one for piece in pieces(samples, stamp) for one in ears.feed(piece)]
    return [*found, *ears.finish()]


@pytest.mark.parametrize("noise", [0.0, 0.0003, 0.003, 0.03])
def test_two_sentences_are_two_utterances_with_their_bounds_whatever_the_noise(noise):
    found = cut(said((1.5, 2.5), (3.7, 4.6), noise=noise), stamp=50.0)
    assert len(found) == 2
    for one, (begin, end) in zip(found, ((51.5, 52.5), (53.7, 54.6)), strict=True):
        assert one.begin == pytest.approx(begin, abs=0.2)
        assert one.end == pytest.approx(end, abs=0.25)


def test_half_a_second_before_the_speech_stays_with_it():
    (one,) = cut(said((2.0, 3.0)))
    assert one.begin - one.sound.stamp == pytest.approx(0.5, abs=0.01)
    assert len(one.before) == pytest.approx(0.5 * RATE_HZ, abs=200)


def test_the_cut_does_not_depend_on_the_size_of_the_pieces():
    samples = said((1.5, 2.5), (3.7, 4.6))
    whole = Endpointer()
    at_once = [*whole.feed(mono(samples)), *whole.finish()]
    bounds = np.array([[(one.begin, one.end) for one in found] for found in (at_once, cut(samples))])
    assert bounds[0] == pytest.approx(bounds[1], abs=1e-6)


def test_a_click_is_no_utterance():
    samples = said()
    samples[3 * RATE_HZ : 3 * RATE_HZ + 60] += 0.5
    assert cut(samples) == []


def test_speech_without_a_pause_is_cut_at_ten_seconds_and_said_to_be():
    found = cut(said((1.0, 12.0), length=12.5))
    assert found[0].cut
    assert found[0].end - found[0].begin < 10.2


def humming(*spans: tuple[float, float], since: float = 2.0, length: float = 14.0) -> np.ndarray:
    """A voice over the given times [s], and a motor that sets in."""
    samples, start = said(*spans, length=length), round(since * RATE_HZ)
    samples[start:] += 0.03 * pink_noise(np.random.default_rng(9), 1, len(samples) - start, RATE_HZ)[0]
    return samples


def test_a_motor_that_sets_in_is_no_utterance_and_soon_taken_for_noise():
    ears, when = Endpointer(), list[float]()
    for piece in pieces(humming()):
        assert not ears.feed(piece)
        when.extend([piece.stamp] if ears.speaking_since is not None else [])
    assert not ears.finish() and 1.9 < when[0] < 2.3 and when[-1] < 4.0


@pytest.mark.parametrize("begin", [0.8, 5.0, 12.0])
def test_a_voice_before_or_in_the_hum_of_a_motor_is_one_utterance(begin):
    (one,) = cut(humming((begin, begin + 1.0)))
    assert (one.begin, one.end) == pytest.approx((begin, begin + 1.0), abs=0.25)
    assert not one.cut


def test_a_voice_into_which_a_motor_sets_in_ends_where_the_steady_noise_begins():
    (one,) = cut(humming((1.0, 2.1)))
    assert one.begin == pytest.approx(1.0, abs=0.2) and 2.0 < one.end < 2.5


def test_after_a_gap_in_the_sound_listening_begins_anew():
    ears = Endpointer()
    for piece in pieces(said((1.0, 1.99), length=2.0)):
        ears.feed(piece)
    assert ears.speaking_since is not None
    ears.feed(pieces(said(), stamp=30.0)[0])
    assert ears.speaking_since is None


def test_hold_to_talk_makes_one_utterance_of_everything_until_the_button_is_let_go():
    held = Held()
    assert [one for piece in pieces(said((0.3, 1.0), (2.2, 3.0), length=3.5)) for one in held.feed(piece)] == []
    (one,) = held.finish()
    assert (one.begin, one.end) == (pytest.approx(0.3, abs=0.2), pytest.approx(3.0, abs=0.3))
    assert held.finish() == ()


def test_speech_beside_the_words_is_noticed():
    (one,) = cut(said((1.5, 3.5)))
    first = one.begin - one.sound.stamp
    whole = (
        WordSpan(word="turn", begin=first, end=first + 1.0),
        WordSpan(word="left", begin=first + 1.0, end=first + 2.1),
    )
    assert left_over(one, whole) < 0.1
    assert left_over(one, whole[:1]) > 0.4


def test_a_recognizer_is_given_one_channel_at_16_khz_whatever_was_recorded():
    tone = np.sin(2 * np.pi * 440 * np.arange(8000) / 8000)
    fitted = for_words(Sound(stamp=3.0, rate=8000, samples=np.column_stack((0 * tone, tone))), channel=1)
    assert (fitted.rate, fitted.channels, fitted.stamp) == (RATE_HZ, 1, 3.0)
    assert np.abs(fitted.samples[2000:-2000]).max() == pytest.approx(1.0, abs=0.02)
    for odd in (Sound(stamp=0.0, rate=4000, samples=np.zeros((10, 1))), fitted):
        with pytest.raises(BadInput):
            for_words(odd, channel=1 if odd is fitted else 0)
    with pytest.raises(BadInput, match="16000 Hz"):
        Endpointer().feed(Sound(stamp=0.0, rate=8000, samples=np.zeros((160, 1))))


def test_a_short_pause_offers_what_was_said_so_far_before_it_is_certainly_over():
    ears = Endpointer()
    offered = [
        (piece.stamp + piece.duration, ears.so_far.end)
        for piece in pieces(said((1.5, 2.5), length=2.9))
        if ears.feed(piece) == () and ears.so_far is not None
    ]
    assert offered[-1][1] == pytest.approx(2.5, abs=0.2)
    assert any(when == pytest.approx(offered[-1][1] + 0.2, abs=0.05) for when, _ in offered)


def test_who_reads_what_was_said_so_far_decides_how_long_a_pause_may_follow() -> None:
    voice = 0.1 * practice_voice(np.random.default_rng(1), 0.8, RATE_HZ)
    for gap, hangover, count in ((0.6, 0.45, 2), (0.6, 0.8, 1), (1.1, 0.8, 2), (0.4, 0.45, 1), (0.4, 0.3, 2)):
        ears, told = Endpointer(), []
        whole = padded(np.concatenate((voice, np.zeros(round(gap * RATE_HZ)), voice)), tail=1.5)
        for piece in mono(whole).pieces(0.1):
            told += ears.feed(piece)
            if ears.so_far is not None:
                ears.hangover = hangover
        assert len([*told, *ears.finish()]) == count


def test_the_words_so_far_are_those_of_the_utterance_under_way() -> None:
    ears = Held()
    assert ears.under_way is None
    for piece in mono(padded(0.1 * practice_voice(np.random.default_rng(1), 0.8, RATE_HZ))).pieces(0.1):
        ears.feed(piece)
    so_far = ears.under_way
    assert so_far is not None and ears.finish()[0].end == so_far.end
