"""Sound → the log mel spectrogram that Whisper reads (Radford et al., "Robust speech recognition", 2022)."""

from functools import cache

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from core.message import Array
from core.speech.settings import RATE_HZ

WINDOW_SAMPLES, HOP_SAMPLES, MEL_BANDS = 400, 160, 80  # samples, samples, mel filters
FRAMES_PER_S = RATE_HZ // HOP_SAMPLES  # in a second
SILENCE_FRAMES = 3 * FRAMES_PER_S  # that follow the sound, which Whisper is used to: 3 s gain 1 nat over 1 s
ROUND_FRAMES = 100  # frames to a multiple of which it is filled up
DYNAMICS_DECADES = 8.0  # decades below the loudest value that are kept


def log_mel(samples: Array) -> Array:
    """Samples (N,), N ≥ 0, of full scale ±1 at 16 kHz → (80, F), the sound and at least 3 s after it."""
    count = max(len(samples), WINDOW_SAMPLES)
    padded = np.zeros(count + HOP_SAMPLES, np.float32)
    padded[: len(samples)] = samples
    padded = np.pad(padded, WINDOW_SAMPLES // 2, mode="reflect")
    frames = sliding_window_view(padded, WINDOW_SAMPLES)[::HOP_SAMPLES][:-1]
    window = np.hanning(WINDOW_SAMPLES + 1)[:-1].astype(np.float32)
    power = np.abs(np.fft.rfft(frames * window, axis=1)) ** 2  # (T, 201)
    length = -(-(len(power) + SILENCE_FRAMES) // ROUND_FRAMES) * ROUND_FRAMES
    mel = np.zeros((MEL_BANDS, length), np.float32)
    mel[:, : len(power)] = filters() @ power.T
    decades = np.log10(np.maximum(mel, 1e-10))
    return ((np.maximum(decades, decades.max() - DYNAMICS_DECADES) + 4) / 4).astype(np.float32)


@cache
def filters() -> Array:
    """Mel filters (80, 201) of Slaney's Auditory Toolbox: linear below 1 kHz, of equal area."""
    edges = _hertz(np.linspace(0.0, _mel(RATE_HZ / 2), MEL_BANDS + 2))
    bins = np.arange(WINDOW_SAMPLES // 2 + 1) * RATE_HZ / WINDOW_SAMPLES
    rising = (bins - edges[:-2, None]) / np.diff(edges)[:-1, None]
    falling = (edges[2:, None] - bins) / np.diff(edges)[1:, None]
    shape = np.maximum(0.0, np.minimum(rising, falling))
    return (shape * (2.0 / (edges[2:] - edges[:-2]))[:, None]).astype(np.float32)


HERTZ_PER_MEL, BEND_HZ = 200 / 3, 1000.0  # [Hz] per mel, and where the logarithm begins
LOG_HZ_PER_MEL = np.log(6.4) / 27  # above that


def _mel(hertz: float) -> float:
    above = float(np.log(max(hertz / BEND_HZ, 1.0))) / LOG_HZ_PER_MEL
    return min(hertz, BEND_HZ) / HERTZ_PER_MEL + above


def _hertz(mel: Array) -> Array:
    bend = BEND_HZ / HERTZ_PER_MEL
    above = BEND_HZ * np.exp(LOG_HZ_PER_MEL * (np.maximum(mel, bend) - bend))
    return np.where(mel < bend, mel * HERTZ_PER_MEL, above)
