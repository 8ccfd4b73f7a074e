"""The paper's estimator as it is printed (eq. 35-40): first microphone against each, whole samples, least squares.

Signs: s points to the source, ΔT_1j = t_1 - t_j is positive where j is nearer. The w_1 of eq. 38 is eq. 37's w, and n
in eq. 39 is the length of the transform. Kept as it is for comparison: no limit on lags. Where it is known when the
speech begins, frames before are noise: they are in X_n and not in the correlation.
"""

import math

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from core.errors import BadInput
from core.message import Array
from core.perception.sound.direction import Direction
from core.perception.sound.least_squares import axes_of, lift, mirrored, on_sphere
from core.sensors.microphones import MicrophoneArray, Sound

FRAME_SAMPLES = 1024  # samples of a frame
HOP_SAMPLES = 512
NOISE_SHARE = 0.4  # share of the noise taken away (eq. 37)
TONE_EXPONENT = 0.3  # emphasis of tones (eq. 38)
NOISE_MEMORY = 0.95  # of the noise's time average, a frame


def mask(power: Array, noise: Array) -> Array:
    """Power X (…, K) and noise X_n (…, K) → weight w (eq. 37 and 38)."""
    masked = np.maximum(0.1, (power - NOISE_SHARE * noise) / np.maximum(power, 1e-300))
    tonal = (np.maximum(power, 1e-300) / np.maximum(noise, 1e-300)) ** TONE_EXPONENT
    return np.where(power > noise, masked * tonal, masked)


def averaged(power: Array) -> Array:
    """Power (T, K) → the time average of what came before each frame (T, K)."""
    noise = np.empty_like(power)
    mean = power[0]
    for number, now in enumerate(power):
        noise[number] = mean
        mean = NOISE_MEMORY * mean + (1 - NOISE_MEMORY) * now
    return noise


def correlations(samples: Array, begin: int = 0) -> Array:
    """Samples (N, M), speech from sample `begin` on → R_1j over lags (SIZE, M - 1), lag 0 first (eq. 39 summed over
    frames with speech).
    """
    if len(samples) < FRAME_SAMPLES:
        raise BadInput(f"The paper's estimator needs at least {FRAME_SAMPLES} samples.")
    window = np.hanning(FRAME_SAMPLES)
    # by frame, microphone and bin: (T, M, K)
    spectra = np.fft.rfft(sliding_window_view(samples, FRAME_SAMPLES, axis=0)[::HOP_SAMPLES] * window, axis=2)
    power = np.mean(np.abs(spectra) ** 2, axis=1)
    weight = mask(power, averaged(power)) ** 2
    phases = spectra / np.maximum(np.abs(spectra), 1e-300)
    last = len(spectra) - 1
    weight[: min(max(math.ceil((begin - FRAME_SAMPLES / 2) / HOP_SAMPLES), 0), last)] = (
        0.0  # half of a frame or more is speech
    )
    summed = np.sum(weight[:, None] * phases[:, :1] * phases[:, 1:].conj(), axis=0)
    return np.fft.irfft(summed, FRAME_SAMPLES, axis=1).T


def locate_as_printed(sound: Sound, array: MicrophoneArray, speech_from: float | None = None) -> Direction:
    """The paper's direction of speech that begins at `speech_from` [s]; None: that is not known.

    Its covariance knows of whole samples only: the paper gives none. Raises BadInput.
    """
    begin = 0 if speech_from is None else round((speech_from - sound.stamp) * sound.rate)
    return direction_as_printed(array.heard(sound), sound.rate, sound.stamp + sound.duration / 2, array, begin)


def direction_as_printed(
    samples: Array, rate: int, stamp: float, array: MicrophoneArray, begin: int = 0
) -> Direction:
    """The same from the array's samples (N, M) at a rate [Hz], of a moment [s]. Raises BadInput."""
    table = correlations(samples, begin)
    top = np.argmax(table, axis=0)
    lags = np.where(top < FRAME_SAMPLES // 2, top, top - FRAME_SAMPLES) / rate  # ΔT_1j (eq. 36)
    axes = axes_of(array)
    matrix = (array.positions[1:] - array.positions[0]) @ axes.T
    within = np.linalg.lstsq(matrix, array.speed * lags, rcond=None)[0]  # (eq. 40)
    towards = lift(array, axes, within)
    step = array.speed / rate / np.sqrt(12)
    return Direction(
        stamp=stamp,
        towards=towards,
        covariance=on_sphere(array, axes, towards, step**2 * np.linalg.inv(matrix.T @ matrix)),
        strength=float(np.clip(np.mean(table.max(axis=0) / np.maximum(np.abs(table).sum(axis=0), 1e-300)), 0, 1)),
        mirror=mirrored(array, towards),
    )
