"""Twists: forward speed and turn rate."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Twist:
    """Speed ahead and speed of turning."""

    v: float = 0.0  # [m/s], forward
    w: float = 0.0  # [rad/s], counter-clockwise

    @property
    def moves(self) -> bool:
        """True unless both speeds are zero."""
        return self.v != 0.0 or self.w != 0.0

    def is_finite(self) -> bool:
        """Return whether both are finite numbers."""
        return math.isfinite(self.v) and math.isfinite(self.w)

    def clamped(self, v: float, w: float) -> Twist:
        """The nearest twist within ±v [m/s] and ±w [rad/s]."""
        return Twist(clamp(self.v, v), clamp(self.w, w))

    def towards(self, wanted: Twist, v: float, w: float) -> Twist:
        """From this one towards `wanted` by at most `v` [m/s] and `w` [rad/s]."""
        return Twist(self.v + clamp(wanted.v - self.v, v), self.w + clamp(wanted.w - self.w, w))


ZERO = Twist()


def clamp(value: float, most: float) -> float:
    """The nearest value within ±most."""
    return max(-most, min(most, value))
