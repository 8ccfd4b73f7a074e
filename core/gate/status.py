"""The status of the gate."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

from core.gate.packets import Packet, construct
from core.sentences import Statement

State = Literal["disarmed", "armed", "halted"]

SILENCE = Statement("gate.reason_silence")
CONSOLE_SILENT = Statement("gate.reason_console_silent")
GATE_LATE = Statement("gate.reason_late")
EXPIRED = "Old: its nonce has expired."  # why a setpoint of a computer that does not come to its work is refused
BUSY = (SILENCE, CONSOLE_SILENT, GATE_LATE)  # what a computer that does not come to its work does to a command
TOO_BUSY = Statement("gate.too_busy")


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
        return Statement("gate.stopped_by_itself", reason=self.reason or "the gate tripped")

    @property
    def refused_because(self) -> str:
        """A sentence that says why the last setpoint did not move the robot."""
        return TOO_BUSY if self.refused == EXPIRED else Statement("gate.refuses", why=self.refused)

    def to_packet(self) -> Packet:
        """Plain values by name; "said" has the codes of the sentences in them."""
        said = {name: value.said for name, value in vars(self).items() if isinstance(value, Statement)}
        return {**vars(self), "said": said}

    @staticmethod
    def of_packet(packet: Packet) -> GateStatus:
        """Read a status from the output of `to_packet`. Raises TypeError."""
        said = packet.pop("said", None)
        if not isinstance(said, dict):
            raise TypeError("said")
        sentences = {name: Statement.of(str(packet[name]), *code) for name, code in said.items()}
        status = construct(GateStatus, packet | sentences)
        return status if status.blocked_by is None else replace(status, blocked_by=_point(*status.blocked_by))


def _point(x: float, y: float) -> tuple[float, float]:
    return float(x), float(y)
