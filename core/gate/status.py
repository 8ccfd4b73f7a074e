"""The status of the gate."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from core.gate.packets import Packet, construct

State = Literal["disarmed", "armed", "halted"]

SILENCE = "silence: no setpoint came for too long"
CONSOLE_SILENT = "the console is silent"
GATE_LATE = "the gate was late"
EXPIRED = "Old: its nonce has expired."  # why a setpoint of a computer that does not come to its work is refused
BUSY = (SILENCE, CONSOLE_SILENT, GATE_LATE)  # what a computer that does not come to its work does to a command
TOO_BUSY = (
    "The computer that runs Beckon was too busy to steer, so the robot stopped by itself. "
    "Close other programs; “beckon doctor” tells how Beckon may run before them."
)


@dataclass(frozen=True)
class GateStatus:
    """The gate at one instant."""

    state: State = "disarmed"
    reason: str = ""  # in words: why it stands, or what slows it
    epoch: int = 0  # of the lease in force, or of the last one
    owner: str = ""  # who holds that lease
    nonce: int = 0  # the newest nonce; a setpoint returns it
    v: float = 0.0  # [m/s] of the wheels
    w: float = 0.0  # [rad/s]
    source: str = ""  # "jog" | "goal" | "": the source of the setpoint in force
    limit_v: float | None = None  # [m/s] while something holds the speed below its usual maximum
    blocked_by: tuple[float, float] | None = None  # (x, y) [m] in the robot frame: what is in the way
    need_neutral: bool = False  # jogging begins with a zero setpoint
    trips: int = 0  # how often it stopped by itself
    latched: int = 0  # number of the newest halt that is on disk
    holds: bool = False  # a command that a busy computer does not steer stands, and may go on
    refused: str = ""  # why the last setpoint was refused; "" when it was accepted

    @property
    def stopped_because(self) -> str:
        """A sentence that says why the robot stopped by itself, and what to do."""
        if self.reason in BUSY:
            return TOO_BUSY
        return f"The robot stopped by itself: {self.reason or 'the gate tripped'}."

    @property
    def refused_because(self) -> str:
        """A sentence that says why the last setpoint did not move the robot."""
        return TOO_BUSY if self.refused == EXPIRED else f"The gate refuses: {self.refused}"

    def to_packet(self) -> Packet:
        """Plain values by name."""
        return dict(vars(self))

    @staticmethod
    def of_packet(packet: Packet) -> GateStatus:
        """Read a status from the output of `to_packet`. Raises TypeError."""
        status = construct(GateStatus, packet)
        return status if status.blocked_by is None else replace(status, blocked_by=_point(*status.blocked_by))


def _point(x: float, y: float) -> tuple[float, float]:
    return float(x), float(y)
