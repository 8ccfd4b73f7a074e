"""Noise taken out of a voice: by one microphone, and by an array that knows where the voice is."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.perception.sound.beamforming import beamform
from core.perception.sound.dereverberation import without_late_echoes
from core.perception.sound.direction import unit
from core.perception.sound.noise_reduction import without_noise
from core.perception.sound.stft import analyse, synthesise
from core.sensors.microphones import RESPEAKER_ODAS, Sound, tetrahedron
from core.simulation.acoustics.shoebox import ShoeboxRoom, heard, impulse_responses, pink_noise, plane_waves
from core.speech.practice_voice import practice_voice

RATE = 16_000
BEFORE = RATE // 2


def voice(seed: int = 0) -> np.ndarray:
    """Half a second of silence, a second of voice."""
    return np.concatenate((np.zeros(BEFORE), practice_voice(np.random.default_rng(seed), 1.0, RATE)))[: 3 * BEFORE]


def ratio(clean: np.ndarray, heard: np.ndarray) -> float:
    """[dB] of what follows `clean`, scaled to fit, over the rest."""
    fitted = clean * (clean @ heard) / (clean @ clean)
    return float(10 * np.log10((fitted @ fitted) / ((heard - fitted) @ (heard - fitted))))


@settings(max_examples=25, deadline=None)
@given(st.integers(1, 4000), st.sampled_from([8000, 16000, 44100]), st.integers(0, 99))
def test_spectra_turn_back_into_the_same_sound(length, rate, seed):
    samples = np.random.default_rng(seed).normal(size=(length, 1))
    assert synthesise(analyse(samples, rate)[:, :, 0], rate, length) == pytest.approx(samples[:, 0], abs=1e-10)


def test_steady_noise_becomes_less_and_the_voice_stays():
    clean = voice()
    noisy = clean + 0.5 * np.random.default_rng(1).normal(size=len(clean))
    assert ratio(clean, without_noise(noisy, RATE, BEFORE)) > ratio(clean, noisy) + 4


def test_with_too_little_before_the_voice_nothing_is_taken_away():
    noisy = voice()[BEFORE:]
    assert without_noise(noisy, RATE, 100) is noisy


@pytest.mark.parametrize("how", ["delay-and-sum", "mvdr"])
@pytest.mark.parametrize("array", [RESPEAKER_ODAS, tetrahedron()], ids=lambda one: one.name)
def test_a_beam_lets_the_voice_through_unchanged(array, how):
    clean = voice()
    towards = unit(0.8, 0.3)
    places = type(array)(positions=array.positions - array.positions.mean(0), speed=array.speed)
    samples = plane_waves(clean[None], towards[None], places.positions, RATE)
    samples += 1e-4 * np.random.default_rng(2).normal(size=samples.shape)
    beam = beamform(Sound(stamp=3.0, rate=RATE, samples=samples), places, towards, 3.5, how)
    assert ratio(clean, beam.samples[:, 0]) > 25


def test_the_microphones_own_noise_falls_by_their_number():
    clean = voice()
    towards = unit(0.8, 0.3)
    samples = plane_waves(clean[None], towards[None], RESPEAKER_ODAS.positions, RATE)
    noisy = samples + 0.3 * np.random.default_rng(3).normal(size=samples.shape)
    beam = beamform(Sound(stamp=0.0, rate=RATE, samples=noisy), RESPEAKER_ODAS, towards, 0.5, "delay-and-sum")
    alone = ratio(samples[:, 0], noisy[:, 0])
    assert ratio(clean, beam.samples[:, 0]) == pytest.approx(alone + 6, abs=0.7)


def test_a_fan_beside_the_talker_is_suppressed_by_more_than_adding_up_can():
    clean = voice()
    towards = unit(0.8, 0.3)
    fan = pink_noise(np.random.default_rng(4), 1, len(clean), RATE)
    samples = plane_waves(
        np.vstack((clean, fan[0])), np.array([towards, unit(2.6, 0.0)]), RESPEAKER_ODAS.positions, RATE
    )
    sound = Sound(stamp=0.0, rate=RATE, samples=samples)
    added, capon = (
        beamform(sound, RESPEAKER_ODAS, towards, 0.5, how).samples[:, 0] for how in ("delay-and-sum", "mvdr")
    )
    assert ratio(clean, capon) > ratio(clean, added) + 3


EARLY = round(0.032 * RATE)  # of an impulse response behind the direct sound, that is the voice


def in_a_room(rt60: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A voice 2 m away from four microphones → it with its early echoes (N, 4), and with all of them."""
    room, rng = ShoeboxRoom((6.0, 5.0, 2.8), rt60), np.random.default_rng(seed)
    centre = np.array([2.0, 2.2, 0.6])
    responses = impulse_responses(
        room, centre + np.array([1.4, 1.2, 0.8]), centre + RESPEAKER_ODAS.positions, RATE, rng
    )
    early = responses.copy()
    early[:, np.abs(responses[0]).argmax() + EARLY :] = 0.0
    return heard(voice(seed), early), heard(voice(seed), responses)


@pytest.mark.parametrize("seed", range(3))
def test_the_late_echoes_of_a_room_become_fewer(seed):
    early, whole = in_a_room(0.6, seed)
    dry = without_late_echoes(whole, RATE)
    gained = [ratio(early[:, m], dry[:, m]) - ratio(early[:, m], whole[:, m]) for m in range(4)]
    assert np.mean(gained) > 1.2


def test_a_voice_without_echoes_stays():
    clean = voice()
    samples = plane_waves(clean[None], unit(0.8, 0.3)[None], RESPEAKER_ODAS.positions, RATE)
    samples += 1e-3 * np.random.default_rng(2).normal(size=samples.shape)
    assert ratio(samples[:, 0], without_late_echoes(samples, RATE)[:, 0]) > 10


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 4000), st.sampled_from([8000, 16000, 44100]), st.integers(1, 8), st.booleans())
def test_sound_of_any_length_has_its_echoes_taken_out(length, rate, channels, silent):
    samples = np.zeros((length, channels)) if silent else np.random.default_rng(0).normal(size=(length, channels))
    dry = without_late_echoes(samples, rate)
    assert dry.shape == samples.shape and np.isfinite(dry).all()
