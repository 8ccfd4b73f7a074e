"""Short-time spectra of all microphones, the noise in them, and the cells that carry fresh sound.

A *cell* is one bin of one frame. Direct sound arrives before its echoes, so a cell counts where its power, measured
in units of the noise, exceeds what earlier cells of its bin may still be echoing (precedence of first wavefronts).
"""

import math

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from core.errors import BadInput
from core.message import Array, message
from core.perception.sound.settings import DirectionFindingSettings

BINS_AT_ONCE = 32  # computed at a time, to spare memory
SILENT_POWER = 1e-14  # power below which nothing but rounding is left


@message
class Spectra:
    """Spectra of M microphones in K bins and T frames."""

    values: Array  # (K, M, T) complex
    frequencies: Array  # (K,) [Hz]
    times: Array  # (T,) [s] from the first sample to the middle of each frame
    size: int  # samples of one frame
    rate: int  # [Hz]


@message
class Noise:
    """The sound at the microphones without speech."""

    cross: Array  # (K, M, M) mean cross spectra, x · xᴴ
    whitener: Array  # (K, M, M): after it, noise has power one and no direction
    has_motors: bool = False  # the robot's own are in it, so it tells nothing about the microphones


def frame_size(rate: int, settings: DirectionFindingSettings) -> int:
    """Samples of a frame: the power of two nearest to the setting."""
    return 2 ** max(4, round(math.log2(rate * settings.frame)))


def spectra(samples: Array, rate: int, settings: DirectionFindingSettings) -> Spectra:
    """Samples (N, M) → spectra within the band. Raises BadInput when the sound is shorter than two frames."""
    size = frame_size(rate, settings)
    if len(samples) < 2 * size:
        raise BadInput(
            f"{len(samples) / rate:.3f} s are too short for a direction; at least {2 * size / rate:.2f} s."
        )
    return framed(samples, rate, settings)


def framed(samples: Array, rate: int, settings: DirectionFindingSettings) -> Spectra:
    """As `spectra`, from one frame's length on."""
    size = frame_size(rate, settings)
    hop = size // settings.steps
    frequencies = np.fft.rfftfreq(size, 1 / rate)
    band = (frequencies >= settings.lowest) & (frequencies <= min(settings.highest, 0.47 * rate))
    window = np.sin(np.pi * (np.arange(size) + 0.5) / size) ** 2
    frames = sliding_window_view(samples, size, axis=0)[::hop]  # (T, M, N)
    values = np.empty((np.count_nonzero(band), frames.shape[1], len(frames)), complex)
    for channel in range(frames.shape[1]):  # one after the other: all frames together take much memory
        values[:, channel] = np.fft.rfft(frames[:, channel] * window)[:, band].T
    times = (hop * np.arange(len(frames)) + size / 2) / rate
    return Spectra(values=values, frequencies=frequencies[band], times=times, size=size, rate=rate)


def quiet_frames(seen: Spectra, settings: DirectionFindingSettings, speech_from: float | None = None) -> Array:
    """(T,) bool: frames of noise alone: those that end before `speech_from` [s], or else the quietest."""
    if speech_from is not None:
        before = seen.times + seen.size / (2 * seen.rate) <= speech_from
        if np.count_nonzero(before) >= settings.steps:
            return before
    level = np.log(np.mean(np.abs(seen.values) ** 2, axis=1) + SILENT_POWER).mean(0)
    return level <= np.quantile(level, settings.quiet_share)


def noise_of(seen: Spectra, frames: Array, settings: DirectionFindingSettings) -> Noise:
    """The noise of the given frames (T,) bool."""
    values = seen.values[:, :, frames]
    return noise_from(values @ values.conj().swapaxes(1, 2) / max(values.shape[2], 1), settings)


def noise_from(cross: Array, settings: DirectionFindingSettings) -> Noise:
    """Mean cross spectra (K, M, M) → the noise, smoothed over neighbouring bins and made safe to invert."""
    wide = settings.smoothing // 2
    weights = np.hanning(2 * wide + 3)[1:-1]
    padded = np.pad(cross, ((wide, wide), (0, 0), (0, 0)), mode="edge")
    smooth = np.zeros_like(cross)
    for n, weight in enumerate(weights / weights.sum()):
        smooth += weight * padded[n : n + len(cross)]
    power = np.trace(smooth, axis1=1, axis2=2).real / cross.shape[1]
    least = settings.loading * power + 1e-6 * power.mean() + SILENT_POWER
    root = np.linalg.cholesky(smooth + least[:, None, None] * np.eye(cross.shape[1]))
    return Noise(cross=smooth, whitener=np.linalg.inv(root))


def over_noise(seen: Spectra, noise: Noise) -> Array:
    """(K, T): power of every cell in units of the noise; a steady fan counts as little from its own direction."""
    white = (np.abs(noise.whitener[k] @ seen.values[k]) ** 2 for k in _parts(seen))
    return np.concatenate([one.mean(axis=1) for one in white])


def cell_weights(power: Array, seen: Spectra, settings: DirectionFindingSettings) -> Array:
    """Power over noise (K, T) → how much each cell counts, 0..1: above the noise and above the echo of what was."""
    step = seen.times[1] - seen.times[0]
    fall = step * 6 * math.log(10) / settings.reverberation  # [nepers of power a frame]
    rise = fall * np.arange(power.shape[1])
    highest = np.maximum.accumulate(np.log(power + SILENT_POWER) + rise, axis=1)
    echo = np.zeros_like(power)
    echo[:, 1:] = np.exp(highest[:, :-1] - rise[1:])
    above = np.maximum(power, settings.evidence)
    fresh = np.clip(1 - settings.precedence * echo / above, 0.0, 1.0) * (1 - 1 / above)
    return np.where(power > settings.evidence, fresh, 0.0)


def cross_spectra(seen: Spectra, weights: Array, noise: Noise) -> Array:
    """Weights (K, T) → cross spectra (K, M, M) of the counting cells, freed from the noise."""
    own = [(seen.values[k] * weights[k, None, :]) @ seen.values[k].conj().swapaxes(1, 2) for k in _parts(seen)]
    return np.concatenate(own) - weights.sum(1)[:, None, None] * noise.cross


def _parts(seen: Spectra) -> list[slice]:
    """All bins, a few at a time: what is computed of them is as large as they are."""
    return [slice(k, k + BINS_AT_ONCE) for k in range(0, len(seen.values), BINS_AT_ONCE)]
