"""One voice out of an array: what comes from its direction is added up, what comes from elsewhere cancels."""

from typing import Literal

import numpy as np

from core.message import Array
from core.perception.sound.stft import analyse, quiet, size_of, synthesise
from core.sensors.microphones import MicrophoneArray, Sound

How = Literal["delay-and-sum", "mvdr"]
LOADING_SHARE = 0.1  # share of the noise's power that every microphone is taken to have for itself
LEAST_FRAMES = 8  # of noise for every microphone, from which its matrix is believed


def beamform(sound: Sound, array: MicrophoneArray, towards: Array, speech_from: float, how: How = "mvdr") -> Sound:
    """A sound of all microphones → one channel, as it comes from `towards` (3,), in phase with the array's centre.

    What precedes `speech_from` [s, the sound's clock] is the noise. "mvdr" (Capon 1969) lets the direction through
    unchanged with the least noise: w = R⁻¹d / (dᴴR⁻¹d); where there is too little of the noise, and with
    "delay-and-sum", w = d / M. Raises BadInput when the sound does not fit the array.
    """
    samples = array.heard(sound)
    spectra = analyse(samples, sound.rate, np.complex64)  # (K, T, M)
    frequencies = np.fft.rfftfreq(size_of(sound.rate), 1 / sound.rate)
    ahead = (array.positions - array.positions.mean(0)) @ towards / array.speed  # [s]
    steering = np.exp(2j * np.pi * np.outer(frequencies, ahead))  # (K, M)
    before = max(round((speech_from - sound.stamp) * sound.rate), 0)
    noise = spectra[:, quiet(spectra.shape[1], before, sound.rate)].astype(complex)
    enough = noise.shape[1] >= LEAST_FRAMES * samples.shape[1]
    weights = _mvdr(steering, noise) if how == "mvdr" and enough else steering / samples.shape[1]
    voice = np.einsum("km,ktm->kt", weights.conj(), spectra)
    return Sound(stamp=sound.stamp, rate=sound.rate, samples=synthesise(voice, sound.rate, len(samples))[:, None])


def _mvdr(steering: Array, noise: Array) -> Array:
    """Directions (K, M) and the noise's spectra (K, T, M) → weights (K, M)."""
    cross = np.einsum("ktm,ktn->kmn", noise, noise.conj()) / noise.shape[1]
    power = np.trace(cross, axis1=1, axis2=2).real / cross.shape[1]
    own = LOADING_SHARE * power + 1e-6 * power.mean() + 1e-14
    solved = np.linalg.solve(cross + own[:, None, None] * np.eye(cross.shape[1]), steering[:, :, None])[:, :, 0]
    return solved / np.einsum("km,km->k", steering.conj(), solved)[:, None]
