"""The link to a robot, wherever it runs: what the console may ask of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from console.messages.state import Link
from core.gate.requests import ReachingPart
from core.gate.setpoint import Setpoint
from core.gate.status import GateStatus
from core.robots import Profile
from core.robots.requests import AnswerT, RobotRequest
from core.sensors import SensorFrame


class RobotLink(Protocol):
    """The robot and its gate, seen from the console.

    Only `start`, `next_frame`, `latch_halt`, `ask` and `close` wait.
    """

    trouble: str  # why there is no robot, a sentence; "" when there is one
    alarm: Callable[[str], None]  # called at every loss of driver or gate, in a sentence; from any thread

    @property
    def profile(self) -> Profile:
        """The robot's profile; known after `start`."""
        ...

    def start(self) -> None:
        """Bring it up. Raises Unavailable with a sentence."""
        ...

    def next_frame(self, timeout: float) -> SensorFrame | None:
        """The newest frame, or None when none came within `timeout` [s]."""
        ...

    def send(self, setpoint: Setpoint) -> None:
        """A request for the gate to judge."""
        ...

    def stop(self) -> None:
        """Zero at once, not latched."""
        ...

    def halt(self) -> None:
        """Zero at once, latched as soon as the disk has it."""
        ...

    def halt_is_latched(self) -> bool:
        """True if the newest halt is on disk and has not been reset."""
        ...

    def latch_halt(self) -> None:
        """Latch the newest halt where the gate does not; waits for the disk. Raises Unavailable."""
        ...

    def reset(self) -> bool:
        """Lift the latch; never moves → whether the request reached the gate."""
        ...

    def arm(self, epoch: int, owner: str) -> None:
        """Obey the holder of this lease from now on."""
        ...

    def disarm(self) -> None:
        """Obey nobody."""
        ...

    def cap(self, speed: float | None) -> None:
        """Move no faster than this [m/s] until another cap comes; None: as the gate's limits say."""
        ...

    def beat(self) -> None:
        """The console is alive."""
        ...

    def reach(self, stamp: float | None, part: ReachingPart = "pilot") -> None:
        """Tell how far a part of the console has come [s], for which a simulated robot waits; None: it need not."""
        ...

    def status(self) -> GateStatus:
        """The gate's newest status."""
        ...

    def ask(self, request: RobotRequest[AnswerT], timeout: float = 2.0) -> AnswerT:
        """A request to the driver → its answer. Raises BadInput, Refused or Unavailable with a sentence."""
        ...

    def link(self) -> tuple[Link, float]:
        """State of the link and the age [s] of the newest frame."""
        ...

    def close(self) -> None:
        """Stop the robot and let go of it."""
        ...
