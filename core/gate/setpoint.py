"""What somebody asks of the wheels, and for how long the asking counts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from core.gate.limits import is_count
from core.gate.twist import Twist

Source = Literal["jog", "goal"]
SOURCES: tuple[Source, ...] = ("jog", "goal")


@dataclass(frozen=True)
class Setpoint:
    """One order: it may come from far away and be late, repeated or nonsense; the gate judges."""

    epoch: int  # of the lease under which it was given
    seq: int  # rises within an epoch and source
    source: Source  # jog: a hand on keys or stick; goal: a command being obeyed
    press: int  # jog: a number drawn with every key press; goal: the undertaking's id
    v: float  # [m/s]
    w: float  # [rad/s]
    nonce: int  # the newest ticket of the gate that its giver had seen

    @property
    def is_well_formed(self) -> bool:
        """Whether everything but the speeds is what it should be."""
        counts = is_count(self.epoch) and is_count(self.seq) and is_count(self.press) and is_count(self.nonce)
        return counts and self.source in SOURCES


@dataclass(frozen=True)
class Order:
    """A setpoint that was accepted."""

    twist: Twist
    source: Source
    press: int
    arrived: float  # [s]
    age: float  # [s] of its ticket when it arrived
