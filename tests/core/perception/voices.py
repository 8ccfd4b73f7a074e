"""Sounds for the tests of hearing: a made-up voice in rooms without walls and with, on any array."""

import numpy as np

from core.message import Array
from core.perception.sound.direction import unit
from core.sensors.microphones import MicrophoneArray, Sound
from core.simulation.acoustics.shoebox import (
    ShoeboxRoom,
    diffuse_noise,
    heard,
    impulse_responses,
    pink_noise,
    plane_waves,
)
from core.speech.practice_voice import practice_voice

RATE = 16_000
PRE_ROLL = 0.5


def far_voice(
    array: MicrophoneArray,
    azimuth: float,
    elevation: float = 0.0,
    *,
    seed: int = 0,
    ratio: float = 20.0,
    duration: float = 1.0,
    fan: float | None = None,
    stamp: float = 0.0,
) -> Sound:
    """A voice from far away after half a second of noise `ratio` [dB] below it; a `fan` blows from that azimuth."""
    rng = np.random.default_rng(seed)
    voice = np.concatenate((np.zeros(int(PRE_ROLL * RATE)), practice_voice(rng, duration, RATE)))
    samples = plane_waves(voice[None], unit(azimuth, elevation)[None], array.positions, RATE, array.speed)
    if fan is None:
        noise = diffuse_noise(rng, array.positions, len(voice), RATE, array.speed)
    else:
        noise = plane_waves(pink_noise(rng, 1, len(voice), RATE), unit(fan)[None], array.positions, RATE, array.speed)
    return Sound(stamp=stamp, rate=RATE, samples=0.05 * (samples + 10 ** (-ratio / 20) * noise))


def voice_in_room(
    array: MicrophoneArray, room: ShoeboxRoom, centre: Array, mouth: Array, *, seed: int = 0, ratio: float = 20.0
) -> Sound:
    """A voice at `mouth` (3,) after half a second of noise from everywhere."""
    rng = np.random.default_rng(seed)
    voice = np.concatenate((np.zeros(int(PRE_ROLL * RATE)), practice_voice(rng, 1.0, RATE)))
    samples = heard(voice, impulse_responses(room, mouth, centre + array.positions, RATE, rng))
    samples /= np.std(samples[int(PRE_ROLL * RATE) :])
    return Sound(
        stamp=0.0,
        rate=RATE,
        samples=0.05 * (samples + 10 ** (-ratio / 20) * diffuse_noise(rng, array.positions, len(voice), RATE)),
    )
