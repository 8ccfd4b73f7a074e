"""Setpoints: the speed asked of the wheels, and for how long the request counts."""

from dataclasses import dataclass
from typing import Literal

from core.gate.limits import is_count
from core.gate.twist import Twist

Source = Literal["jog", "goal"]
SOURCES: tuple[Source, ...] = ("jog", "goal")


@dataclass(frozen=True)
class Setpoint:
    """One request for a speed: it may come from far away and be late, repeated or malformed; the gate judges."""

    epoch: int  # of the lease under which it was given
    seq: int  # rises within an epoch and source
    source: Source  # jog: a hand on keys or stick; goal: a command under way
    press: int  # what it belongs to: of a jog the number drawn with every key press, of a goal the command's id
    v: float  # [m/s]
    w: float  # [rad/s]
    nonce: int  # the newest nonce of the gate that its sender had seen

    @property
    def is_well_formed(self) -> bool:
        """True if every field but the speeds has the right type and range."""
        counts = is_count(self.epoch) and is_count(self.seq) and is_count(self.press) and is_count(self.nonce)
        return counts and self.source in SOURCES


@dataclass(frozen=True)
class AcceptedSetpoint:
    """A setpoint that was accepted."""

    twist: Twist
    source: Source
    press: int
    arrived: float  # [s]
    age: float  # [s] of its nonce when it arrived


@dataclass(frozen=True)
class HeldCommand:
    """A command that stands because the computer was too busy to steer it, and may go on."""

    press: int  # its id
    until: float  # [s]
    reason: str
