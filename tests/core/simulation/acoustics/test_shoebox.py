"""Rooms of images: arrivals where geometry puts them, walls that send back what they should."""

import numpy as np
import pytest

from core.errors import BadInput
from core.simulation.acoustics.shoebox import ShoeboxRoom, diffuse_noise, impulse_responses, pink_noise, plane_waves

RATE = 16_000
SOURCE, EARS = np.array([2.0, 2.0, 1.5]), np.array([[4.0, 3.0, 1.0], [4.1, 3.0, 1.0]])


def delay_of(response: np.ndarray) -> float:
    """Place [samples] of the strongest arrival, between samples by its spectrum's phase."""
    top = int(np.argmax(np.abs(response)))
    part = response[top - 20 : top + 21] * np.hanning(41)
    return top + float(np.sum(part**2 * np.arange(-20, 21)) / np.sum(part**2))


def test_without_walls_only_the_direct_sound_arrives_in_time_and_by_one_over_distance():
    response = impulse_responses(ShoeboxRoom((6, 5, 3), 0.0), SOURCE, EARS, RATE)
    for own, ear in zip(response, EARS, strict=True):
        distance = np.linalg.norm(SOURCE - ear)
        assert delay_of(own) == pytest.approx(distance / 343 * RATE, abs=0.15)
        energy = np.sum(own**2) * distance**2
        assert energy == pytest.approx(1.0, abs=0.06)


def test_the_first_echoes_are_those_of_the_mirror_images():
    room = ShoeboxRoom((6, 5, 3), 0.3)
    with_walls = impulse_responses(room, SOURCE, EARS, RATE)[0]
    floor = np.linalg.norm(SOURCE * (1, 1, -1) - EARS[0])
    place = round(floor / 343 * RATE)
    echo = np.max(with_walls[place - 2 : place + 3])
    assert echo == pytest.approx(room.reflection / floor, rel=0.35)


@pytest.mark.parametrize("rt60", [0.3, 0.6])
def test_sound_dies_away_in_the_time_that_the_room_is_said_to_have(rt60):
    response = impulse_responses(ShoeboxRoom((6, 5, 3), rt60), SOURCE, EARS[:1], RATE, np.random.default_rng(0))[0]
    left = 10 * np.log10(np.cumsum(response[::-1] ** 2)[::-1] / np.sum(response**2))
    early, late = np.argmax(left < -5), np.argmax(left < -25)
    assert 3 * (late - early) / RATE == pytest.approx(rt60, rel=0.35)


def test_a_plane_wave_reaches_nearer_microphones_earlier():
    signal = np.zeros((1, 2000))
    signal[0, 1000] = 1.0
    heard = plane_waves(signal, np.array([[1.0, 0, 0]]), np.array([[0.0, 0, 0], [0.343, 0, 0], [0, 1.0, 0]]), RATE)
    assert np.argmax(heard, axis=0).tolist() == [1000, 1000 - 16, 1000]


def test_noise_from_everywhere_is_as_alike_between_microphones_as_theory_says():
    apart = 0.1
    positions = np.array([[0.0, 0, 0], [apart, 0, 0]])
    rng = np.random.default_rng(0)
    spectra = [np.fft.rfft(diffuse_noise(rng, positions, 512, RATE), axis=0) for _ in range(300)]
    cross = np.mean([one[:, 0] * one[:, 1].conj() for one in spectra], axis=0)
    power = np.mean([np.abs(one) ** 2 for one in spectra], axis=0)
    alike = cross.real / np.sqrt(power[:, 0] * power[:, 1])
    expected = np.sinc(2 * np.fft.rfftfreq(512, 1 / RATE) * apart / 343)
    assert np.sqrt(np.mean((alike - expected)[3:200] ** 2)) < 0.12


def test_pink_noise_loses_three_decibels_an_octave():
    noise = pink_noise(np.random.default_rng(1), 4, 1 << 16, RATE)
    power = np.mean(np.abs(np.fft.rfft(noise, axis=1)) ** 2, axis=0)
    hertz = np.fft.rfftfreq(1 << 16, 1 / RATE)
    low, high = (power[(hertz > f) & (hertz < 2 * f)].mean() for f in (500, 2000))
    assert low / high == pytest.approx(4.0, rel=0.2)


@pytest.mark.parametrize(("source", "words"), [((7.0, 1, 1), "inside the room"), ((1.0, -1, 1), "inside the room")])
def test_points_outside_the_room_are_refused(source, words):
    with pytest.raises(BadInput, match=words):
        impulse_responses(ShoeboxRoom((6, 5, 3), 0.2), np.array(source), EARS, RATE)


@pytest.mark.parametrize(("size", "rt60"), [((0, 5, 3), 0.2), ((5, 5, float("nan")), 0.2), ((5, 5, 3), 11.0)])
def test_rooms_that_cannot_be_are_refused(size, rt60):
    with pytest.raises(BadInput):
        ShoeboxRoom(size, rt60)


def test_a_cupboard_that_echoes_for_seconds_is_refused_rather_than_computed():
    with pytest.raises(BadInput, match="too small"):
        impulse_responses(ShoeboxRoom((0.5, 0.5, 0.5), 5.0), np.full(3, 0.2), np.full((1, 3), 0.3), RATE)
