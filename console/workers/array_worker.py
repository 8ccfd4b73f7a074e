"""The worker that looks at an array's sound: is it wired as its profile says, and where did a clap come from?"""

from __future__ import annotations

from typing import Any

import numpy as np

from core.perception.sound.array_diagnostics import check
from core.perception.sound.array_orientation import heard_from
from core.sensors.microphones import MicrophoneArray, Sound


class ArrayWorker:
    """Remembers nothing from one recording to the next."""

    def check(self, sound: dict[str, Any], array: dict[str, Any]) -> list[dict[str, Any]]:
        """A recording with some speech in it → everything that looks wrong. Raises BadInput."""
        return [
            {"kind": one.kind, "channels": list(one.channels), "sentence": one.sentence, "serious": one.serious}
            for one in check(sound_in(sound), array_in(array))
        ]

    def heard_from(self, sound: dict[str, Any], array: dict[str, Any]) -> dict[str, float]:
        """A recording with a clap or a word in it → its azimuth in the array's frame [rad]. Raises BadInput."""
        found = heard_from(sound_in(sound), array_in(array))
        return {"azimuth_rad": found.azimuth, "sd_rad": found.azimuth_sd, "strength": found.strength}


def sound_fields(sound: Sound) -> dict[str, Any]:
    """A sound in plain values."""
    raw = np.ascontiguousarray(sound.samples, np.float32).tobytes()
    return {"stamp": sound.stamp, "rate": sound.rate, "channels": sound.channels, "samples": raw}


def sound_in(fields: dict[str, Any]) -> Sound:
    """Plain values → a sound."""
    samples = np.frombuffer(fields["samples"], np.float32).astype(float).reshape(-1, fields["channels"])
    return Sound(stamp=fields["stamp"], rate=fields["rate"], samples=samples)


def array_fields(array: MicrophoneArray) -> dict[str, Any]:
    """The part of an array that directions in its own frame need, in plain values."""
    return {
        "positions": array.positions.tolist(),
        "channels": list(array.channels),
        "name": array.name,
        "rate": array.rate,
        "speed": array.speed,
        "position_sd": array.position_sd,
    }


def array_in(fields: dict[str, Any]) -> MicrophoneArray:
    """Plain values → an array."""
    return MicrophoneArray(
        positions=np.array(fields["positions"]),
        channels=tuple(fields["channels"]),
        name=fields["name"],
        rate=fields["rate"],
        speed=fields["speed"],
        position_sd=fields["position_sd"],
    )
