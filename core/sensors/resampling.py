"""Sound at another sample rate."""

import math

import numpy as np

from core.message import Array

ZERO_CROSSINGS = 10  # of zero on each side of the low-pass filter
KAISER_BETA = 5.0  # shape of its window


def resampled(samples: Array, rate: float, wanted: float) -> Array:
    """Samples (N, …) of `rate` [Hz] → samples (M, …) of `wanted` [Hz], by polyphase filtering; whole numbers.

    The filter is that of scipy.signal.resample_poly. That package takes 50 MB and half a second to import, which the
    process of a simulated robot or of a recognizer would pay for this function alone.
    """
    if rate == wanted:
        return samples
    common = math.gcd(round(rate), round(wanted))
    up, down = round(wanted) // common, round(rate) // common
    taps = _taps(up, down)  # (J, up)
    before = len(taps) // 2
    length = -(-len(samples) * up // down)
    first, phase = np.divmod(np.arange(length) * down, up)
    padded = np.pad(samples, ((before, before + 1), *[(0, 0)] * (samples.ndim - 1)))
    found = np.zeros((length, *samples.shape[1:]))
    for row, tap in enumerate(taps):
        found += (tap[phase] * padded[first + row].T).T
    return found


def _taps(up: int, down: int) -> Array:
    """Weights (J, up) of the samples around each of the `up` phases between two of them, J odd."""
    widest = max(up, down)
    reach = ZERO_CROSSINGS * widest
    before = reach // up + 1
    at = np.arange(up) - up * np.arange(-before, before + 1)[:, None]  # in samples of the common multiple
    window = np.i0(KAISER_BETA * np.sqrt(np.maximum(1 - (at / reach) ** 2, 0))) / np.i0(KAISER_BETA)
    weights = np.where(np.abs(at) <= reach, np.sinc(at / widest) * window, 0.0)
    return weights * (up / weights.sum())
