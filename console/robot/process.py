"""The robot as the console speaks to it: frames come, setpoints, stops and requests go.

Nothing here beats by itself: the owner of the console's life calls `beat` every 50 ms, so that a frozen console is a
silent one.
"""

from __future__ import annotations

import time
from dataclasses import asdict
from typing import Literal

from console.robot.supervisor import RobotSupervisor
from core.errors import Unavailable
from core.gate import GateStatus, Setpoint
from core.gate.limits import is_number
from core.robots.ipc_messages import DriverTrouble
from core.robots.requests import AnswerT, RobotRequest, read_answer
from core.sensors import SensorFrame

STALE, LOST = 0.5, 3.0  # [s], age of the newest frame


class RobotProcess(RobotSupervisor):
    """One robot. `start` raises what the driver says; afterwards a fault shows in `link`, `status` and `trouble`."""

    def next_frame(self, timeout: float) -> SensorFrame | None:
        """The newest frame that nobody took yet, or None when none comes within `timeout` [s]."""
        return self._mail.take_frame(timeout)

    def send(self, setpoint: Setpoint) -> None:
        """A request for the gate to judge."""
        if setpoint.v or setpoint.w:
            self._presses[setpoint.source] = setpoint.press
        speeds = {name: value if is_number(value) else None for name, value in (("v", setpoint.v), ("w", setpoint.w))}
        self._send({"kind": "set", **asdict(setpoint), **speeds})

    def beat(self) -> None:
        """Report that the console is alive: call every 50 ms from the loop without which the robot must not move."""
        self._send({"kind": "beat"})

    def stop(self) -> None:
        """Zero at once; a new press may move."""
        self._insist("stop")

    def halt(self) -> None:
        """Zero at once. The gate latches it; `halt_is_latched` tells when it has."""
        with self._switching:
            self._insist("halt", number=self._halt.ask())

    def halt_is_latched(self) -> bool:
        """True if the newest halt is on disk and has not been reset."""
        return self._halt.is_latched(self._status.latched)

    def latch_halt(self) -> None:
        """Latch the newest halt from here, where the gate does not; waits for the disk. Raises Unavailable."""
        with self._switching:
            if self._halt.asked and not self.halt_is_latched():
                self._halt.keep()

    def reset(self) -> bool:
        """Lift the halt; never moves → whether the request reached the gate."""
        with self._switching:
            sent = self._send({"kind": "reset"})
            self._halt.asked = self._halt.asked and not sent
        return sent

    def arm(self, epoch: int, owner: str) -> None:
        """Obey the holder of this lease from now on."""
        self._send({"kind": "arm", "epoch": epoch, "owner": owner})

    def disarm(self) -> None:
        """Obey nobody."""
        self._insist("disarm")

    def status(self) -> GateStatus:
        """The gate's newest status."""
        return self._status

    def link(self) -> tuple[Literal["connecting", "live", "stale", "lost"], float]:
        """State of the link, and the age [s] of the newest frame (of the start, before the first)."""
        frame_at = self._frame_at  # the robot's thread may forget it meanwhile
        if frame_at is None:
            return ("lost" if self.trouble else "connecting"), 0.0
        age = time.monotonic() - frame_at
        if self.trouble or age > LOST:
            return "lost", age
        return ("live" if age <= STALE else "stale"), age

    def ask(self, request: RobotRequest[AnswerT], timeout: float = 2.0) -> AnswerT:
        """A request to the driver → its answer. Raises BadInput, Refused or Unavailable with a sentence."""
        ref, driver = self._mail.open_question(), self._driver
        if driver is None or not driver.ask(ref, request):
            self._mail.take_answer(ref, 0.0)
            raise Unavailable("The robot cannot be asked now.")
        answer = self._mail.take_answer(ref, timeout)
        if answer is None:
            raise Unavailable(f"The robot did not answer within {timeout:g} s.")
        if isinstance(answer, DriverTrouble):
            raise answer.error
        return read_answer(answer, request)
