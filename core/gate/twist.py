"""What the wheels are asked to do."""

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
        """Whether anything would turn."""
        return self.v != 0.0 or self.w != 0.0

    def is_finite(self) -> bool:
        """Whether both are finite numbers."""
        return math.isfinite(self.v) and math.isfinite(self.w)


ZERO = Twist()
