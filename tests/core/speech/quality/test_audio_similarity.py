"""orig.wav against rev.wav: measures that others use too."""

import numpy as np
import pytest

from core.errors import BadInput
from core.message import Array
from core.sensors.microphones import Sound
from core.simulation.acoustics.shoebox import ShoeboxRoom, heard, impulse_responses
from core.speech.practice_voice import practice_voice
from core.speech.quality.audio_similarity import health, liken
from core.speech.quality.stoi import si_sdr, stoi
from core.speech.quality.time_alignment import match

RATE = 16_000
VOICE = 0.05 * practice_voice(np.random.default_rng(1), 3.0, RATE)
NOISE = 0.05 * np.random.default_rng(2).normal(size=len(VOICE))


def sound(samples: Array, rate: int = RATE) -> Sound:
    return Sound(stamp=0.0, rate=rate, samples=samples[:, None])


def in_noise(ratio: float) -> Array:
    """The voice with white noise, `ratio` [dB] below."""
    return VOICE + 10 ** (-ratio / 20) * NOISE


def test_a_copy_is_perfect_however_loud() -> None:
    one = liken(sound(VOICE), sound(0.3 * VOICE))
    assert one.figures["stoi"] == pytest.approx(1.0, abs=1e-6)
    assert one.figures["estoi"] == pytest.approx(1.0, abs=1e-6)
    assert one.figures["si_sdr_db"] == 100.0  # capped
    assert one.figures["level_change_db"] == pytest.approx(20 * np.log10(0.3), abs=0.01)


def test_si_sdr_is_the_ratio_of_voice_and_noise() -> None:
    for ratio in (20.0, 10.0, 0.0):
        assert si_sdr(VOICE, in_noise(ratio)) == pytest.approx(ratio, abs=0.5)


def test_more_noise_and_more_echo_are_less_understood() -> None:
    noisy = [stoi(VOICE, in_noise(ratio), RATE) or 0 for ratio in (30.0, 20.0, 10.0, 0.0, -10.0)]
    assert noisy == sorted(noisy, reverse=True)
    source, ear = np.array([2.0, 2.0, 1.5]), np.array([[4.0, 2.5, 0.5]])
    rooms = [ShoeboxRoom((6.0, 5.0, 2.7), rt60) for rt60 in (0.0, 0.3, 0.6)]
    echoing = [
        liken(sound(VOICE), sound(heard(VOICE, impulse_responses(room, source, ear, RATE))[:, 0])) for room in rooms
    ]
    assert echoing[0].figures["estoi"] == pytest.approx(1.0, abs=0.02)
    assert (
        (echoing[0].figures["estoi"] or 0) > (echoing[1].figures["estoi"] or 0) > (echoing[2].figures["estoi"] or 0)
    )


@pytest.mark.parametrize("extended", [False, True])
def test_intelligibility_is_that_of_pystoi(extended: bool) -> None:
    pystoi = pytest.importorskip("pystoi", reason="pystoi is not installed: the peer to compare with")
    for ratio in (20.0, 5.0, -5.0):
        theirs = pystoi.stoi(VOICE, in_noise(ratio), RATE, extended=extended)
        assert stoi(VOICE, in_noise(ratio), RATE, extended=extended) == pytest.approx(theirs, abs=2e-3)


def test_speech_that_was_lost_is_said_to_be_left_out_of_the_figures() -> None:
    whole, half = (liken(sound(VOICE), sound(some)).figures for some in (VOICE, VOICE[: len(VOICE) // 2]))
    assert (whole["compared_share"], whole["compared_note"]) == (1.0, "")
    assert half["compared_share"] == pytest.approx(0.5) and "Only 50 % of the original" in half["compared_note"]


def test_a_delay_is_found_and_taken_out() -> None:
    for late in (4000, -3000):
        moved = np.concatenate((np.zeros(late), VOICE)) if late > 0 else VOICE[-late:]
        one = liken(sound(VOICE), sound(moved))
        assert one.matched.delay == pytest.approx(late / RATE, abs=1e-4)
        assert (one.figures["stoi"] or 0) > 0.999


def test_another_rate_and_another_sign_do_not_matter() -> None:
    time = np.arange(0, len(VOICE) * 3) / 48_000
    faster = -np.interp(time, np.arange(len(VOICE)) / RATE, VOICE)
    one = liken(sound(VOICE), sound(faster, 48_000))
    assert one.matched.inverted
    assert one.figures["received"]["sample_rate_hz"] == 48_000
    assert (one.figures["stoi"] or 0) > 0.97


def test_clipping_level_and_noise_floor_are_told() -> None:
    loud = np.clip(VOICE / 0.05, -1, 1)
    assert health(sound(loud))["clipped_share"] > 0.05
    assert health(sound(VOICE))["clipped_share"] == 0.0
    assert health(sound(VOICE))["level_dbfs"] == pytest.approx(20 * np.log10(0.05), abs=0.3)
    assert health(sound(0 * VOICE))["noise_floor_dbfs"] == -120.0


@pytest.mark.parametrize(
    ("received", "sentence"),
    [
        (0 * VOICE, "is silent"),
        (VOICE[:1000], "0.1 s long"),
        (np.random.default_rng(5).normal(size=len(VOICE)), "nothing in common"),
    ],
)
def test_what_cannot_be_compared_is_told(received: Array, sentence: str) -> None:
    with pytest.raises(BadInput, match=sentence):
        match(sound(VOICE), sound(received))


def test_too_short_for_intelligibility_says_nothing_rather_than_something() -> None:
    assert stoi(VOICE[:3000], VOICE[:3000], RATE) is None
    assert si_sdr(0 * VOICE, VOICE) is None
