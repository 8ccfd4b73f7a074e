"""Somebody was heard: from where to where, and when."""

from __future__ import annotations

import math

from core.message import message
from core.perception.people.fusion import Ray


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
        sector = round(angle / 45) % 8
        return SIDES[sector]


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
