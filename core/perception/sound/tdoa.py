"""Time differences of arrival (TDOA): the peak of a generalized cross-correlation (GCC-PHAT), between samples, within
what the array allows.
"""

import math
from dataclasses import replace

import numpy as np

from core.message import Array
from core.perception.sound.least_squares import axes_of
from core.perception.sound.plane_wave import ECHO_SD_M, LAG_SD_M, PlaneWaveFit, explain, noise_sd_of
from core.perception.sound.spectra import Noise
from core.perception.sound.srp import STEPS_PER_SAMPLE, Correlation
from core.sensors.microphones import MicrophoneArray

SLACK_SAMPLES = 0.5  # [samples] beyond the way between two microphones that a peak may lie
MAX_ROUNDS = 10
LATEST_SAMPLES = 10  # by which a channel is searched for in noise
MAX_UNLIKE = 0.08  # mean squared difference of the noise's coherence from that of noise from everywhere
SHARED_NOISE = 0.18  # squared coherence of two microphones beyond that of the two with least, where sound is short
FEWEST_BINS = 8  # of a spectrum, in which that is looked for
CONVERGED_STEP_S = 1e-7  # a step of a time that is no longer worth making


def pair_lags(correlation: Correlation, array: MicrophoneArray) -> Array:
    """Lead [s] of microphone j over i of each pair, (P,) (eq. 36 with limits and a parabola through the top)."""
    tables = correlation.tables()
    length, count = tables.shape
    reach = np.linalg.norm(array.baselines, axis=1) / array.speed * correlation.rate
    lags = np.arange(-(length // 2), length // 2)
    allowed = np.abs(lags)[:, None] <= (reach + SLACK_SAMPLES) * STEPS_PER_SAMPLE
    shifted = np.where(allowed, np.roll(tables, length // 2, axis=0), -np.inf)
    top = np.argmax(shifted, axis=0)
    pair = np.arange(count)
    place = (top + length - length // 2) % length
    before, here, after = tables[(place - 1) % length, pair], tables[place, pair], tables[(place + 1) % length, pair]
    bend = before - 2 * here + after
    shift = np.where(bend < 0, (before - after) / np.where(bend < 0, 2 * bend, 1.0), 0.0)
    best = (lags[top] + np.clip(shift, -1, 1)) / STEPS_PER_SAMPLE
    return np.clip(best, -reach, reach) / correlation.rate


def fit_plane_wave(
    correlation: Correlation, array: MicrophoneArray, starts: Array, noise: Noise, bands: int
) -> PlaneWaveFit:
    """Correlation of all pairs, and the pairs' lags (S, P) [s] at which to begin → the microphones' times that agree
    best, the plane wave through them, and the noise's times. As far as the `bands` of the spectrum disagree, a rest
    is expected. Raises BadInput where the microphones lie in a line.
    """
    axes = axes_of(array)
    power, leads = max(
        (_climb(correlation, array, _times_of(array, lags)) for lags in starts), key=lambda one: one[0]
    )
    strength = min(1.0, max(0.0, power / max(correlation.total, 1e-300)))
    places = array.positions @ axes.T
    apart = np.column_stack((np.zeros_like(leads), _steps_of_bands(correlation, array, leads, bands)))
    within, residuals, freedom = explain(places, array.speed * (leads[:, None] + apart))
    uncertain = np.sum((residuals[:, 1:] - residuals[:, :1]) ** 2) * bands / (bands - 1) / max(int(freedom[0]), 1)
    agreement = np.real(_turned(correlation, array, leads)).sum(0)
    shared = np.full((len(leads), len(leads)), -1.0)
    first, second = array.pairs.T
    shared[first, second] = agreement / np.maximum(np.abs(correlation.values).sum(0), 1e-300)
    return PlaneWaveFit(
        times=leads * array.speed,
        within=within[:, 0],
        residuals=residuals[:, 0],
        freedom=int(freedom[0]),
        expected_sd=math.hypot(array.position_sd, LAG_SD_M, ECHO_SD_M * (1 - strength), math.sqrt(uncertain)),
        expected_noise_sd=noise_sd_of(places),
        shared=np.maximum(shared, shared.T).max(1),
        noise_times=None if noise.has_motors else _noise_times(noise, correlation, array),
        sharing=() if noise.has_motors else _sharing(noise, correlation, array),
    )


def _noise_times(noise: Noise, correlation: Correlation, array: MicrophoneArray) -> Array | None:
    """The microphones' times (M,) [m] in noise, at the frequencies of a correlation; None where it does not come from
    everywhere alike: its coherence is then no sin(x)/x of frequency and distance (a fan, the microphones' own noise).
    """
    first, second = array.pairs.T
    power = np.real(np.diagonal(noise.cross, axis1=1, axis2=2))
    coherence = noise.cross[:, first, second] / np.sqrt(power[:, first] * power[:, second] + 1e-300)
    apart = np.linalg.norm(array.baselines, axis=1)
    diffuse = np.sinc(correlation.omega[:, None] * apart / (np.pi * array.speed))
    matched = replace(correlation, values=coherence * diffuse)
    tables = matched.tables()
    lags = np.arange(-LATEST_SAMPLES * STEPS_PER_SAMPLE, LATEST_SAMPLES * STEPS_PER_SAMPLE + 1)
    tops = lags[np.argmax(tables[lags], axis=0)] / (STEPS_PER_SAMPLE * correlation.rate)
    starts = (_times_of(array, tops), np.zeros(len(array.positions)))
    _, leads = max((_climb(matched, array, start) for start in starts), key=lambda one: one[0])
    turned = _turned(replace(correlation, values=coherence), array, leads)
    return array.speed * leads if np.mean(np.abs(turned - diffuse) ** 2) < MAX_UNLIKE else None


def _sharing(noise: Noise, correlation: Correlation, array: MicrophoneArray) -> tuple[int, ...]:
    """Two microphones that share noise which others do not; () where all share as much, or little.

    Above the first zero of sin(x)/x between the closest two, noise from everywhere has little in common at any two,
    that of a fan much at all, that of two fans much at most. A channel that holds the sound of another (cross-talk, a
    sum), or sits closer to it than the profile says, has much with that one alone.
    """
    short = correlation.omega * np.linalg.norm(array.baselines, axis=1).min() > math.pi * array.speed
    if np.count_nonzero(short) < FEWEST_BINS:
        return ()
    first, second = array.pairs.T
    cross = noise.cross[short]
    power = np.real(np.diagonal(cross, axis1=1, axis2=2))
    common = np.mean(np.abs(cross[:, first, second]) ** 2 / (power[:, first] * power[:, second] + 1e-300), axis=0)
    most, beyond = int(np.argmax(common)), common - common.min()
    alone = beyond[most] > SHARED_NOISE and np.median(beyond) < SHARED_NOISE / 2
    return tuple(array.pairs[most].tolist()) if alone else ()


def _times_of(array: MicrophoneArray, lags: Array) -> Array:
    """Lags (P,) [s] of the pairs → leads (M,) [s] that agree with them best, 0 on the average."""
    return np.linalg.lstsq(_differences(array), lags, rcond=None)[0]


def _differences(array: MicrophoneArray) -> Array:
    one = np.eye(len(array.positions))
    return one[array.pairs[:, 1]] - one[array.pairs[:, 0]]


def _turned(correlation: Correlation, array: MicrophoneArray, leads: Array) -> Array:
    """Correlations (K, P) as they are where the microphones hear with these leads (M,) [s]."""
    first, second = array.pairs.T
    return correlation.values * np.exp(1j * np.outer(correlation.omega, leads[second] - leads[first]))


def _steps_of_bands(correlation: Correlation, array: MicrophoneArray, leads: Array, bands: int) -> Array:
    """Steps (M, B) [s] by which every band of the spectrum would have the leads (M,) [s] changed."""
    turned, omega = _turned(correlation, array, leads), correlation.omega[:, None]
    slopes = -omega * np.imag(turned) @ _differences(array)
    votes = np.column_stack([band.sum(0) for band in np.array_split(slopes, bands)])
    return np.linalg.lstsq(_bend(turned, omega, array), votes - votes.mean(1, keepdims=True), rcond=None)[0]


def _bend(turned: Array, omega: Array, array: MicrophoneArray) -> Array:
    """Bend (M, M) of the power over the leads, made safe."""
    bend, differences = np.abs((omega**2 * np.real(turned)).sum(0)), _differences(array)
    return (differences.T * np.maximum(bend, 1e-3 * bend.max() + 1e-300)) @ differences


def _climb(correlation: Correlation, array: MicrophoneArray, leads: Array) -> tuple[float, Array]:
    """Newton's steps uphill from leads (M,) [s] → the power where they end, and the leads."""
    differences, omega = _differences(array), correlation.omega[:, None]
    turned = _turned(correlation, array, leads)
    power = float(np.real(turned).sum())
    for _ in range(MAX_ROUNDS):
        slope = -(omega * np.imag(turned)).sum(0)
        step = np.linalg.lstsq(_bend(turned, omega, array), differences.T @ slope, rcond=None)[0]
        while np.abs(step).max() > CONVERGED_STEP_S:
            there = _turned(correlation, array, leads + step)
            higher = float(np.real(there).sum())
            if higher > power:
                leads, power, turned = leads + step, higher, there
                break
            step = step / 2
        else:
            break
    return power, leads - leads.mean()
