"""Lags to directions (eq. 40), and the paper's estimator as printed (eq. 35-39)."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.stats import chi2

from core.errors import BadInput
from core.perception.sound.array_diagnostics import contradiction
from core.perception.sound.direction import Direction, unit
from core.perception.sound.least_squares import fit_lags, on_sphere
from core.perception.sound.locate import DEFAULT, locate, sure, whitened
from core.perception.sound.paper import NOISE_SHARE, TONE_EXPONENT, averaged, correlations, locate_as_printed, mask
from core.perception.sound.plane_wave import PlaneWaveFit, noise_sd_of
from core.perception.sound.spectra import cross_spectra, noise_of, quiet_frames, spectra
from core.perception.sound.tdoa import pair_lags
from core.sensors.microphones import RESPEAKER_ODAS, MicrophoneArray, ring, tetrahedron
from core.simulation.acoustics.shoebox import diffuse_noise
from tests.core.perception.lags import direction_from_lags, lags_of
from tests.core.perception.voices import PRE_ROLL, RATE, far_voice

ARRAYS = [RESPEAKER_ODAS, tetrahedron()]
angles = st.tuples(st.floats(-3.1, 3.1), st.floats(0.05, 1.3))


@pytest.mark.parametrize("array", ARRAYS, ids=lambda a: a.name)
@given(where=angles)
def test_exact_lags_give_the_exact_direction(array, where):
    towards = unit(*where)
    fit = fit_lags(array, array.pairs, lags_of(array, towards[None])[0])
    assert np.linalg.norm(fit.towards - towards) < 1e-5
    assert np.abs(fit.residuals).max() < 1e-6


def test_one_lag_in_forty_seven_that_is_wrong_does_not_move_the_direction():
    rng = np.random.default_rng(0)
    array = MicrophoneArray(positions=rng.uniform(-0.12, 0.12, (48, 3)))
    pairs = np.array([[0, other] for other in range(1, 48)])
    towards = unit(2.0, 0.3)
    lags = (array.positions[1:] - array.positions[0]) @ towards / array.speed + rng.normal(scale=2e-6, size=47)
    reach = np.linalg.norm(array.positions[1:] - array.positions[0], axis=1) / array.speed
    lags[[5, 17]] = -np.sign(lags[[5, 17]]) * 0.95 * reach[[5, 17]]
    plain = fit_lags(array, pairs, lags, robust=False)
    robust = direction_from_lags(array, pairs, lags)
    assert np.linalg.norm(plain.towards - towards) > 0.03
    assert robust.angle_to(towards) < math.radians(0.2)


def test_lags_longer_than_the_array_are_left_out_and_too_few_are_refused():
    array = tetrahedron()
    lags = lags_of(array, unit(0.3, 0.2)[None])[0]
    lags[2] = 1.0
    fit = fit_lags(array, array.pairs, lags)
    assert np.isnan(fit.residuals[2]) and np.linalg.norm(fit.towards - unit(0.3, 0.2)) < 1e-6
    with pytest.raises(BadInput, match="Too few lags"):
        fit_lags(array, array.pairs, np.full(6, np.nan))


@pytest.mark.parametrize("array", ARRAYS, ids=lambda a: a.name)
def test_the_covariance_of_lags_holds(array):
    rng = np.random.default_rng(1)
    exact = MicrophoneArray(positions=array.positions, position_sd=0.0)
    inside = []
    for _ in range(300):
        towards = unit(rng.uniform(-3, 3), rng.uniform(0.2, 0.8))
        lags = lags_of(exact, towards[None])[0] + rng.normal(scale=4e-6, size=6)
        direction = direction_from_lags(exact, exact.pairs, lags)
        gap = math.remainder(direction.azimuth - math.atan2(towards[1], towards[0]), 2 * math.pi)
        inside.append(abs(gap) < 2 * direction.azimuth_sd)
    assert 0.90 <= np.mean(inside) <= 0.99


@given(where=angles)
def test_the_slope_from_plane_to_sphere_is_its_finite_difference(where):
    array, towards = RESPEAKER_ODAS, unit(*where)
    axes = array.axes[0][:2]
    spread = np.diag([1e-10, 4e-10])
    if towards[2] < 0.1:
        return
    told = on_sphere(array, axes, towards, spread)
    rng = np.random.default_rng(0)
    drawn = axes @ towards + rng.multivariate_normal([0, 0], spread, 4000)
    points = drawn @ axes + np.sqrt(1 - np.sum(drawn**2, axis=1))[:, None] * array.normal
    azimuths = np.unwrap(np.arctan2(points[:, 1], points[:, 0]) - math.atan2(towards[1], towards[0]))
    assert np.std(azimuths) * math.cos(where[1]) == pytest.approx(math.sqrt(told[0, 0]), rel=0.1)
    assert np.std(np.arcsin(points[:, 2])) == pytest.approx(math.sqrt(told[1, 1]), rel=0.1)


@pytest.mark.parametrize("array", ARRAYS, ids=lambda a: a.name)
def test_lags_are_found_between_samples(array):
    towards = unit(0.9, 0.3)
    sound = far_voice(array, 0.9, 0.3, ratio=30)
    seen = spectra(array.heard(sound), RATE, DEFAULT)
    noise = noise_of(seen, quiet_frames(seen, DEFAULT, PRE_ROLL), DEFAULT)
    cross = cross_spectra(seen, np.ones((len(seen.frequencies), len(seen.times))), noise)
    lags = pair_lags(whitened(cross, seen, array, DEFAULT), array)
    assert lags * RATE == pytest.approx(lags_of(array, towards[None])[0] * RATE, abs=0.12)


def test_the_noise_mask_is_equation_37_and_the_tonal_weight_equation_38():
    power, noise = np.array([1.0, 10.0, 0.1]), np.array([2.0, 1.0, 0.1])
    expected = [max(0.1, (1 - NOISE_SHARE * 2) / 1), (10 - NOISE_SHARE) / 10 * 10**TONE_EXPONENT, 1 - NOISE_SHARE]
    assert mask(power, noise) == pytest.approx(expected)
    assert mask(np.array([1.0]), np.array([1e3])) == pytest.approx([0.1])


def test_the_noise_is_an_average_of_what_came_before():
    power = np.array([[1.0], [2.0], [4.0]])
    assert averaged(power)[:, 0] == pytest.approx([1.0, 1.0, 1.05])


def test_the_correlation_of_equation_39_peaks_at_whole_lags_positive_where_j_is_nearer():
    signal = np.random.default_rng(0).normal(size=6000)
    samples = np.column_stack((signal[:-10], np.roll(signal, -3)[:-10], np.roll(signal, 5)[:-10]))
    top = np.argmax(correlations(samples), axis=0)
    assert top.tolist() == [3, 1024 - 5]


@pytest.mark.parametrize(
    "array", [MicrophoneArray(positions=4 * one.positions) for one in ARRAYS], ids=["flat", "solid"]
)
def test_as_printed_the_estimator_works_in_the_open_on_a_wide_array(array):
    direction = locate_as_printed(far_voice(array, 0.8, 0.3, ratio=30), array)
    assert direction.azimuth == pytest.approx(0.8, abs=math.radians(6))


def test_the_printed_form_is_not_judged_by_a_strength_that_it_does_not_have():
    found = Direction(stamp=0.0, towards=unit(0.3, 0.1), covariance=0.2**2 * np.eye(2), strength=0.03)
    printed = replace(DEFAULT, form="paper")
    assert sure(found, printed) and not sure(found, DEFAULT)
    assert not sure(replace(found, covariance=np.eye(2)), printed)


def test_as_printed_a_sound_must_fill_a_frame():
    with pytest.raises(BadInput, match="1024"):
        correlations(np.zeros((100, 4)))


@pytest.mark.parametrize("array", [*ARRAYS, ring("eight", 0.0525, 0.0, 0.785, 8)], ids=lambda a: a.name)
@given(draws=st.lists(st.floats(-1, 1), min_size=8, max_size=8), scale=st.floats(0.1, 10))
def test_what_a_misfit_is_by_chance_adds_nothing_to_a_direction_and_more_does(array, draws, scale):
    count = len(array.positions)
    noise = scale * noise_sd_of(array.positions) * np.array(draws[:count])
    fit = PlaneWaveFit(
        times=np.zeros(count),
        within=np.zeros(2),
        residuals=np.zeros(count),
        freedom=0,
        expected_sd=0.001,
        expected_noise_sd=noise_sd_of(array.positions),
        shared=np.ones(count),
        noise_times=noise,
    )
    by_chance = math.sqrt(float(chi2.ppf(0.95, count - 1)) / (count - 1))
    assume(abs(fit.misfit - by_chance) > 0.02)
    assert (fit.excess > 0) == (fit.misfit > by_chance)
    assert noise_sd_of(2 * array.positions) > 1.5 * noise_sd_of(array.positions)


@pytest.mark.parametrize(("own", "other"), [(0.6, 0.4), (0.5, 0.5)])
def test_two_channels_that_hear_each_other_make_no_direction_sure_and_are_named(own, other):
    array = ring("three", 0.04, 0.3, 2 * math.pi / 3, 3)
    voice = far_voice(array, 0.6, 0.2)
    surrounding = 0.003 * diffuse_noise(np.random.default_rng(0), array.positions, len(voice.samples), RATE)
    right = voice.samples + surrounding
    wrong = np.column_stack((own * right[:, 0] + other * right[:, 1], right[:, 1:]))
    for samples, sharing in ((right, ()), (wrong, (0, 1))):
        found = locate(replace(voice, samples=samples), array, speech_from=PRE_ROLL)
        assert found is not None and found.fit is not None and found.fit.sharing == sharing
        assert sure(found) == (not sharing)
        told = contradiction([found], array)
        assert (told is None) == (not sharing) and (told is None or "Channels 1 and 2 share noise" in told.sentence)
