"""Sound → short-time spectra of the whole band, and back to the same sound."""

import math

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from core.message import Array

FRAME_S = 0.032
STEPS_PER_FRAME = 4  # frames per frame length


def size_of(rate: int) -> int:
    """Samples of a frame: the power of two nearest to FRAME."""
    return 2 ** max(4, round(math.log2(rate * FRAME_S)))


def analyse(samples: Array, rate: int, kind: type[np.complexfloating] = np.complex128) -> Array:
    """Samples (N, M) → spectra (K, T, M) of a `kind`; frame t begins `(t - 3)` quarter frames after the first sample.

    One microphone after the other: the frames of all of them take ten times the memory of their sound.
    """
    size = size_of(rate)
    hop = size // STEPS_PER_FRAME
    behind = -len(samples) % hop + size - hop
    padded = np.pad(samples, ((size - hop, behind), (0, 0)))
    frames = sliding_window_view(padded, size, axis=0)[::hop]  # (T, M, N)
    spectra = np.empty((size // 2 + 1, *frames.shape[:2]), kind)
    for channel in range(frames.shape[1]):
        spectra[:, :, channel] = np.fft.rfft(frames[:, channel] * _window(size)).T
    return spectra


def synthesise(spectra: Array, rate: int, length: int) -> Array:
    """Spectra (K, T) of one channel → its samples (`length`,): the inverse of `analyse`."""
    size = size_of(rate)
    hop = size // STEPS_PER_FRAME
    frames = np.fft.irfft(spectra, size, axis=0).T * _window(size)  # (T, N)
    quarters = frames.reshape(len(frames), STEPS_PER_FRAME, hop)
    total = np.zeros((len(frames) + STEPS_PER_FRAME - 1, hop))
    for step in range(STEPS_PER_FRAME):
        total[step : step + len(frames)] += quarters[:, step]
    return total.ravel()[size - hop :][:length]


def quiet(frames: int, before: int, rate: int) -> slice:
    """Which of `frames` hold only what was heard in the first `before` samples."""
    size = size_of(rate)
    hop = size // STEPS_PER_FRAME
    return slice(STEPS_PER_FRAME - 1, min(frames, max(STEPS_PER_FRAME, (before - size) // hop + STEPS_PER_FRAME)))


def _window(size: int) -> Array:
    """Root of a Hann window, scaled so that analysis and synthesis together give one."""
    return np.sin(np.pi * (np.arange(size) + 0.5) / size) * math.sqrt(2 / STEPS_PER_FRAME)
