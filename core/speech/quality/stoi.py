"""Measures of how much clean speech is left in degraded speech: STOI, ESTOI and SI-SDR.

Taal et al., "An algorithm for intelligibility prediction of time-frequency weighted noisy speech", 2011; Jensen and
Taal, "An algorithm for predicting the intelligibility of speech masked by modulated noise maskers", 2016; Le Roux et
al., "SDR - half-baked or well done?", 2019. All compare two signals of equal length that begin together.
"""

import math

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from core.errors import BadInput
from core.message import Array
from core.sensors.resampling import resampled

RATE_HZ = 10_000  # at which intelligibility is judged
FRAME_SAMPLES, STEP_SAMPLES, SPECTRUM_SIZE = 256, 128, 512  # of a frame, between frames, points of a spectrum
BAND_COUNT, LOWEST_BAND_HZ = 15, 150.0  # third octaves, and the middle [Hz] of the lowest
SEGMENT_FRAMES = 30  # frames that are correlated together, 384 ms
CLIP = 10 ** (15 / 20)  # how far a band may exceed the clean one (-15 dB)
SILENT_DB = 40.0  # below the loudest frame, from which a frame does not count
MOST_DB = 100.0  # SI-SDR beyond is rounding
TINY = np.finfo(float).eps


def stoi(clean: Array, degraded: Array, rate: int, *, extended: bool = False) -> float | None:
    """Clean and degraded speech (N,) at `rate` [Hz] → share understood, about 0..1; None for less than 0.4 s.

    `extended`: ESTOI, which also holds where the noise comes and goes. Raises BadInput for unequal lengths.
    """
    _check(clean, degraded)
    pair = [resampled(one, rate, RATE_HZ) for one in (clean, degraded)]
    bands = [_bands(one) for one in _without_silence(*pair)]
    if bands[0].shape[1] < SEGMENT_FRAMES:
        return None
    ours, theirs = (sliding_window_view(one, SEGMENT_FRAMES, axis=1).swapaxes(0, 1) for one in bands)  # (S, 15, 30)
    if extended:
        return float(np.mean(np.sum(_standing(ours) * _standing(theirs), axis=(1, 2)) / SEGMENT_FRAMES))
    gain = np.linalg.norm(ours, axis=2, keepdims=True) / (np.linalg.norm(theirs, axis=2, keepdims=True) + TINY)
    held = np.minimum(theirs * gain, ours * (1 + CLIP))
    return float(np.mean(np.sum(_unit(ours, 2) * _unit(held, 2), axis=2)))


def si_sdr(clean: Array, degraded: Array) -> float | None:
    """Clean and degraded speech (N,) → scale-invariant signal-to-distortion ratio [dB], at most 100; None: silence.

    Reverberation counts as distortion, however well it is understood.
    """
    _check(clean, degraded)
    ours, theirs = clean - clean.mean(), degraded - degraded.mean()
    energy = float(ours @ ours)
    if not energy > 0 or not float(theirs @ theirs) > 0:
        return None
    target = float(ours @ theirs) / energy * ours
    rest = theirs - target
    left, lost = float(target @ target), float(rest @ rest)
    if left == 0:
        return -MOST_DB
    return min(MOST_DB, max(-MOST_DB, 10 * math.log10(left / lost))) if lost > 0 else MOST_DB


def _check(clean: Array, degraded: Array) -> None:
    if clean.shape != degraded.shape or clean.ndim != 1:
        raise BadInput("Only recordings of equal length can be compared.")


def _frames(samples: Array) -> Array:
    """Windowed frames (T, FRAME)."""
    if len(samples) <= FRAME_SAMPLES:
        return np.zeros((0, FRAME_SAMPLES))
    window = np.hanning(FRAME_SAMPLES + 2)[1:-1]
    return sliding_window_view(samples, FRAME_SAMPLES)[: len(samples) - FRAME_SAMPLES : STEP_SAMPLES] * window


def _without_silence(clean: Array, degraded: Array) -> tuple[Array, Array]:
    """Both without the frames in which the clean one is silent, put together again."""
    ours, theirs = _frames(clean), _frames(degraded)
    if not len(ours):
        return clean[:0], degraded[:0]
    energy = 20 * np.log10(np.linalg.norm(ours, axis=1) + TINY)
    loud = energy > energy.max() - SILENT_DB
    return _together(ours[loud]), _together(theirs[loud])


def _together(frames: Array) -> Array:
    """Frames that overlap by half → one signal."""
    signal = np.zeros((len(frames) + 1) * STEP_SAMPLES)
    signal[: len(frames) * STEP_SAMPLES] += frames[:, :STEP_SAMPLES].ravel()
    signal[STEP_SAMPLES:] += frames[:, STEP_SAMPLES:].ravel()
    return signal


def _bands(samples: Array) -> Array:
    """A signal → magnitude in third octaves over time, (BANDS, T)."""
    power = np.abs(np.fft.rfft(_frames(samples), SPECTRUM_SIZE)) ** 2
    return np.sqrt(_third_octaves() @ power.T)


def _third_octaves() -> Array:
    """Which bins of a spectrum belong to which band, (BANDS, SIZE // 2 + 1)."""
    frequencies = np.linspace(0, RATE_HZ, SPECTRUM_SIZE + 1)[: SPECTRUM_SIZE // 2 + 1]
    edges = LOWEST_BAND_HZ * 2 ** ((2 * np.arange(BAND_COUNT)[:, None] + np.array([-1, 1])) / 6)
    nearest = np.argmin(np.abs(edges[..., None] - frequencies), axis=2)
    bins = np.arange(len(frequencies))
    return ((bins >= nearest[:, :1]) & (bins < nearest[:, 1:])).astype(float)


def _unit(values: Array, axis: int) -> Array:
    centred = values - values.mean(axis=axis, keepdims=True)
    return centred / (np.linalg.norm(centred, axis=axis, keepdims=True) + TINY)


def _standing(segments: Array) -> Array:
    """Rows, then columns without mean and of length one."""
    return _unit(_unit(segments, 2), 1)
