"""The bearing of a voice that was heard: from where to where, and when."""

import math
from collections.abc import Sequence
from dataclasses import replace

from core.geometry import Ray, wrap
from core.message import message
from core.perception.people.fusion import GATE_CHI2

SAME_BEARING_RAD = 0.3  # within which two bearings are looked at together


@message
class VoiceBearing:
    """The direction of a voice at the moment of speaking."""

    stamp: float  # [s] when it was heard last
    azimuth: float  # [rad] world
    sd: float  # [rad]
    x: float  # [m] world: where the robot was
    y: float  # [m]
    strength: float = 1.0  # 0..1

    @property
    def ray(self) -> Ray:
        """The bearing as a ray."""
        return Ray(x=self.x, y=self.y, azimuth=self.azimuth, sd=self.sd)

    def side(self, heading: float) -> str:
        """The side in words, for a robot with this heading: "ahead", "left", "behind you to the right" …"""
        angle = math.degrees(math.remainder(self.azimuth - heading, math.tau))
        return SIDES[round(angle / 45) % 8]


def likeliest(heard: Sequence[VoiceBearing]) -> tuple[VoiceBearing, ...]:
    """Bearings of the moments of words → the directions from which they may have come, the likeliest first.

    A direction has the strengths of all moments in which it was heard; in one moment it counts once.
    """
    moments = sorted({one.stamp for one in heard})
    support = {
        number: sum(max(_agreement(one, each) for each in heard if each.stamp == stamp) for stamp in moments)
        for number, one in enumerate(heard)
    }
    found: list[VoiceBearing] = []
    for number in sorted(support, key=lambda each: -support[each]):
        one = replace(heard[number], strength=support[number] / len(moments), stamp=moments[-1])
        if all(abs(wrap(one.azimuth - other.azimuth)) > SAME_BEARING_RAD for other in found):
            found.append(one)
    return tuple(found)


def _agreement(one: VoiceBearing, other: VoiceBearing) -> float:
    miss = wrap(one.azimuth - other.azimuth) ** 2 / (one.sd**2 + other.sd**2)
    return other.strength * max(0.0, 1 - miss / GATE_CHI2)


def from_side(side: str) -> str:
    """A side as one says from where a voice came: "from the left", "ahead on the left"."""
    return f"from {side}" if side[0] in "tb" or side == "ahead" else side


SIDES = (
    "ahead",
    "ahead on the left",
    "the left",
    "behind on the left",
    "behind",
    "behind on the right",
    "the right",
    "ahead on the right",
)
