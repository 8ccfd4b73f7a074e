"""A person talks in a room, and several arrays in one place listen."""

import math
from collections.abc import Sequence

import numpy as np

from core.message import Array, message
from core.sensors.microphones import MicrophoneArray, Sound
from core.simulation.acoustics.shoebox import (
    ShoeboxRoom,
    diffuse_noise,
    heard,
    impulse_responses,
    pink_noise,
    plane_waves,
)

RATE_HZ = 16_000
PRE_ROLL_S = 0.5  # of noise before the first word
FAN_APART_RAD = math.radians(25)  # a fan stands at least this far from the talker


@message
class AcousticScene:
    """The sound at all microphones of all arrays from the talker, diffuse noise and a fan; power 1 each."""

    rt60: float  # [s]
    towards: Array  # (3,) from the arrays to the talker
    voice: Array  # (N, M)
    diffuse: Array  # (N, M)
    fan: Array  # (N, M)
    columns: tuple[slice, ...]  # which microphones are each array's

    def sound(self, array: int, noise: str, ratio: float, speech: float = math.inf) -> Sound:
        """The array's sound with `noise` ("diffuse" or "fan") `ratio` [dB] below the voice, `speech` [s] of it."""
        own = self.columns[array]
        other = self.diffuse if noise == "diffuse" else self.fan
        samples = self.voice[:, own] + 10 ** (-ratio / 20) * other[:, own]
        end = min(len(samples), int((PRE_ROLL_S + min(speech, 1e3)) * RATE_HZ))
        return Sound(stamp=0.0, rate=RATE_HZ, samples=0.05 * samples[:end])


def make_scene(
    rng: np.random.Generator, rt60: float, voice: Array, arrays: Sequence[MicrophoneArray]
) -> AcousticScene:
    """A room of 5-9 x 4-7 x 2.5-3.2 m, a talker 1-4 m away at 1.2-1.8 m height, arrays at 0.25-1 m.

    Every microphone stands where its profile says give or take the profile's `position_sd`.
    """
    room = ShoeboxRoom((rng.uniform(5, 9), rng.uniform(4, 7), rng.uniform(2.5, 3.2)), rt60)
    centre, mouth = _places(rng, room)
    places = np.vstack(
        [one.positions + rng.normal(scale=one.position_sd, size=one.positions.shape) for one in arrays]
    )
    dry = np.concatenate((np.zeros(int(PRE_ROLL_S * RATE_HZ)), voice))
    responses = impulse_responses(room, mouth, centre + places, RATE_HZ, rng)
    towards = (mouth - centre) / np.linalg.norm(mouth - centre)
    azimuth = math.atan2(towards[1], towards[0]) + rng.uniform(FAN_APART_RAD, 2 * math.pi - FAN_APART_RAD)
    blowing = np.array([[math.cos(azimuth), math.sin(azimuth), 0.0]])
    ends = np.cumsum([len(one.positions) for one in arrays])
    return AcousticScene(
        rt60=rt60,
        towards=towards,
        voice=_power_one(heard(dry, responses), int(PRE_ROLL_S * RATE_HZ)),
        diffuse=_power_one(diffuse_noise(rng, places, len(dry), RATE_HZ), 0),
        fan=_power_one(plane_waves(pink_noise(rng, 1, len(dry), RATE_HZ), blowing, places, RATE_HZ), 0),
        columns=tuple(slice(end - len(one.positions), end) for one, end in zip(arrays, ends.tolist(), strict=True)),
    )


def _places(rng: np.random.Generator, room: ShoeboxRoom) -> tuple[Array, Array]:
    """Places of the arrays (3,) and the mouth (3,), both well inside."""
    while True:
        x, y, _ = room.size
        centre = np.array([rng.uniform(0.8, x - 0.8), rng.uniform(0.8, y - 0.8), rng.uniform(0.25, 1.0)])
        distance, azimuth = rng.uniform(1, 4), rng.uniform(-math.pi, math.pi)
        aside = distance * np.array([math.cos(azimuth), math.sin(azimuth)])
        mouth = np.append(centre[:2] + aside, rng.uniform(1.2, 1.8))
        if 0.3 < mouth[0] < x - 0.3 and 0.3 < mouth[1] < y - 0.3:
            return centre, mouth


def _power_one(sound: Array, begin: int) -> Array:
    return sound / np.sqrt(np.mean(sound[begin:] ** 2))
