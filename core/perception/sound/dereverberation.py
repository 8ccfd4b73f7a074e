"""Late echoes of a room taken out of a voice: what earlier sound predicts is an echo of it.

Weighted prediction error of Nakatani and others, "Speech dereverberation based on variance-normalized delayed linear
prediction", 2010: in every frequency band, frames of all microphones predict the frame that comes DELAY later. Frames
weigh by the inverse of the voice's power in them, so that pauses, where echoes are alone, count most. What is not
predicted is the voice with its early echoes. Nothing is known of the room.
"""

import numpy as np

from core.message import Array
from core.perception.sound.stft import analyse, synthesise

DELAY_FRAMES = 3  # frames of 8 ms, within which sound is the voice itself and what is near it
TAP_FRAMES = 5  # frames of every microphone that predict
PREDICTION_ROUNDS = 2  # of the voice's power and the prediction
BANDS_AT_ONCE = 32  # at a time: what predicts is TAP_FRAMES times as large as the spectra
LEAST_POWER = 1e-4  # of the loudest frame of a band: below, frames weigh alike
LOADING_SHARE = 1e-5  # of the mean power of what predicts
SILENT_POWER = 1e-12  # power of rounding


def without_late_echoes(samples: Array, rate: int) -> Array:
    """Samples (N, M) of all microphones → the same (N, M) with less of the room in them."""
    spectra = analyse(samples, rate, np.complex64)  # (K, T, M)
    for k in range(0, len(spectra), BANDS_AT_ONCE):
        spectra[k : k + BANDS_AT_ONCE] = _dry(spectra[k : k + BANDS_AT_ONCE])
    return np.stack([synthesise(one, rate, len(samples)) for one in spectra.transpose(2, 0, 1)], axis=1)


def _dry(spectra: Array) -> Array:
    """Spectra (K, T, M) → the same without what is predicted."""
    bands, frames, channels = spectra.shape
    earlier = np.zeros((bands, frames, TAP_FRAMES * channels), spectra.dtype)
    for tap in range(TAP_FRAMES):
        ago = DELAY_FRAMES + tap
        earlier[:, ago:, tap * channels : (tap + 1) * channels] = spectra[:, : max(frames - ago, 0)]
    voice = spectra
    for _ in range(PREDICTION_ROUNDS):
        voice = spectra - earlier @ _prediction(earlier, spectra, voice)
    return voice


def _prediction(earlier: Array, spectra: Array, voice: Array) -> Array:
    """Frames that predict (K, T, P), all frames (K, T, M) and the voice so far → the prediction (K, P, M)."""
    power = (np.abs(voice) ** 2).mean(2)  # (K, T)
    weights = 1 / (np.maximum(power, LEAST_POWER * power.max(1, keepdims=True)) + SILENT_POWER)
    weighted = (earlier.conj() * weights[:, :, None]).transpose(0, 2, 1)
    among = weighted @ earlier  # (K, P, P)
    loading = LOADING_SHARE * np.trace(among, axis1=1, axis2=2).real / among.shape[1] + SILENT_POWER
    own = loading[:, None, None] * np.eye(among.shape[1], dtype=among.dtype)
    return np.linalg.solve(among + own, weighted @ spectra)
