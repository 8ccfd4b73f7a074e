"""Sound at another sample rate."""

from __future__ import annotations

from core.message import Array


def resampled(samples: Array, rate: float, wanted: float) -> Array:
    """Samples (N, …) of `rate` [Hz] → samples (M, …) of `wanted` [Hz], by polyphase filtering; whole numbers."""
    if rate == wanted:
        return samples
    from scipy.signal import resample_poly  # takes 50 MB and half a second, and most microphones do without it

    return resample_poly(samples, wanted, rate, axis=0)
