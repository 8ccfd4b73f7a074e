"""A voice made of nothing: pulses through three resonances, hiss between them, in the rhythm of speech.

It says no words. It serves where only the timing of sound matters and no recording is at hand.
"""

import numpy as np

from core.message import Array

VOWELS = (
    (730, 1090, 2440),
    (270, 2290, 3010),
    (300, 870, 2240),
    (530, 1840, 2480),
    (570, 840, 2410),
    (660, 1720, 2410),
)
"""Resonances [Hz] of six vowels (Peterson and Barney 1952)."""


def practice_voice(rng: np.random.Generator, duration: float, rate: int) -> Array:
    """`duration` [s] of voice at `rate` [Hz], (N,), power about 1 while it speaks; it begins at once."""
    pieces: list[Array] = []
    pitch = rng.uniform(90, 220)
    while sum(map(len, pieces)) < duration * rate:
        pieces.append(_hiss(rng, rng.uniform(0.03, 0.09), rate))
        pieces.append(_vowel(rng, pitch * rng.uniform(0.85, 1.2), rng.uniform(0.08, 0.24), rate))
        if rng.random() < 0.15:
            pieces.append(np.zeros(int(rng.uniform(0.05, 0.2) * rate)))
    voice = np.concatenate(pieces)[: int(duration * rate)]
    return voice / np.std(voice)


def _vowel(rng: np.random.Generator, pitch: float, duration: float, rate: int) -> Array:
    """Pulses at a gliding pitch [Hz] through the resonances of one vowel."""
    from scipy.signal import lfilter  # takes half a second, and few processes make sound

    time = np.arange(int(duration * rate)) / rate
    phase = np.cumsum(pitch * (1 + rng.uniform(-0.8, 0.8) * (time - duration / 2))) / rate
    pulses = np.diff(np.floor(phase), prepend=0.0) + 0.02 * rng.normal(size=len(time))
    sound = pulses
    for resonance in VOWELS[rng.integers(len(VOWELS))]:
        centre = resonance * rng.uniform(0.93, 1.07)
        radius = np.exp(-np.pi * (50 + 0.05 * centre) / rate)
        sound = lfilter([1.0], [1.0, -2 * radius * np.cos(2 * np.pi * centre / rate), radius**2], np.asarray(sound))
    sound = np.asarray(sound)
    rise = np.minimum(1.0, np.minimum(time, time[::-1]) / 0.015)
    return sound * rise / (np.std(sound) + 1e-12)


def _hiss(rng: np.random.Generator, duration: float, rate: int) -> Array:
    noise = np.diff(rng.normal(size=int(duration * rate) + 1))
    return noise * np.hanning(len(noise)) * rng.uniform(0.1, 0.5)
