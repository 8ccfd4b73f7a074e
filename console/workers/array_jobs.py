"""Messages about an array and its sound, and the jobs of the worker that looks at both."""

from __future__ import annotations

import msgspec
import numpy as np

from console.workers.job import Job
from core.perception.sound.array_diagnostics import ArrayFault
from core.sensors.microphones import MicrophoneArray, Sound


class SoundMessage(msgspec.Struct, frozen=True):
    """A piece of sound."""

    stamp: float  # [s] of the first sample
    rate: int  # [Hz]
    channels: int
    samples: bytes  # 32-bit numbers, channel by channel of each moment

    @classmethod
    def of(cls, sound: Sound) -> SoundMessage:
        """A sound as it crosses."""
        raw = np.ascontiguousarray(sound.samples, np.float32).tobytes()
        return cls(sound.stamp, sound.rate, sound.channels, raw)

    @property
    def sound(self) -> Sound:
        """The sound."""
        samples = np.frombuffer(self.samples, np.float32).astype(float).reshape(-1, self.channels)
        return Sound(stamp=self.stamp, rate=self.rate, samples=samples)


class ArrayMessage(msgspec.Struct, frozen=True):
    """The part of an array that directions in its own frame need."""

    positions: list[tuple[float, float, float]]  # [m]
    channels: tuple[int, ...]
    name: str
    rate: int | None  # [Hz]
    speed: float  # [m/s] of sound
    position_sd: float  # [m]

    @classmethod
    def of(cls, array: MicrophoneArray) -> ArrayMessage:
        """An array as it crosses."""
        positions = [(x, y, z) for x, y, z in array.positions.tolist()]
        return cls(positions, tuple(array.channels), array.name, array.rate, array.speed, array.position_sd)

    @property
    def array(self) -> MicrophoneArray:
        """The array."""
        return MicrophoneArray(
            positions=np.array(self.positions),
            channels=self.channels,
            name=self.name,
            rate=self.rate,
            speed=self.speed,
            position_sd=self.position_sd,
        )


class HeardAzimuth(msgspec.Struct, frozen=True):
    """The direction of a clap in the array's frame."""

    azimuth_rad: float
    sd_rad: float
    strength: float


class CheckArray(Job[tuple[ArrayFault, ...]], frozen=True):
    """A recording with some speech in it → everything that looks wrong. Raises BadInput."""

    sound: SoundMessage
    array: ArrayMessage


class FindClap(Job[HeardAzimuth], frozen=True):
    """A recording with a clap or a word in it → its direction. Raises BadInput."""

    sound: SoundMessage
    array: ArrayMessage
