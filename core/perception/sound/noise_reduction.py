"""Steady noise taken out of a voice, learnt from the half second before it began.

Wiener's gain with the decision-directed signal-to-noise ratio of Ephraim and Malah, "Speech enhancement using a
minimum mean-square error short-time spectral amplitude estimator", 1984.
"""

import numpy as np

from core.message import Array
from core.perception.sound.stft import analyse, quiet, synthesise

MIN_GAIN = 0.25  # least gain: what is left of the noise hides the gaps that would sound like consonants
RATIO_MEMORY = 0.96  # of the ratio of the frame before
MIN_NOISE_S = 0.1  # of noise from which it is learnt at all
SILENT_POWER = 1e-14  # power of rounding


def without_noise(samples: Array, rate: int, before: int) -> Array:
    """Samples (N,), of which the first `before` hold noise alone → the same with less of that noise."""
    if before < MIN_NOISE_S * rate:
        return samples
    spectra = analyse(samples[:, None], rate)[:, :, 0]  # (K, T)
    power = np.abs(spectra) ** 2
    noise = _smooth(power[:, quiet(power.shape[1], before, rate)].mean(1)) + SILENT_POWER
    return synthesise(spectra * _gains(power / noise[:, None]), rate, len(samples))


def _gains(ratio: Array) -> Array:
    """Power over the noise's (K, T) → gains (K, T)."""
    gains = np.empty_like(ratio)
    left = np.zeros(len(ratio))  # power of the voice over the noise's in the frame before
    for t, now in enumerate(ratio.T):
        expected = RATIO_MEMORY * left + (1 - RATIO_MEMORY) * np.maximum(now - 1, 0)
        gain = np.maximum(expected / (1 + expected), MIN_GAIN)
        gains[:, t] = gain
        left = gain**2 * now
    return gains


def _smooth(power: Array) -> Array:
    """(K,) averaged over neighbouring bins."""
    weights = np.array([1.0, 2, 3, 2, 1])
    return np.convolve(np.pad(power, 2, mode="edge"), weights / weights.sum(), mode="valid")
