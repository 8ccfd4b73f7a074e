"""The console's hand on the gate: goals from the pilot thread, jogs and stops from the event loop, in one order."""

import itertools
import threading
import time
from collections.abc import Callable

from console.messages.inbound import JogMessage
from console.robot.supervisor import RobotSupervisor
from core.gate.setpoint import Setpoint
from core.gate.twist import ZERO, Twist
from core.snapshot import Snapshot

REPEATED_STOP_S = 0.02  # within which the same stop, with no command between, is not sent again: no flood


class SetpointSender:
    """Sends a goal's setpoints only while the goal is authorized, under the lease it was authorized with.

    The lock makes a stop final: whatever the pilot computed before it is not sent after it.
    """

    def __init__(self, robot: RobotSupervisor) -> None:
        self._robot = robot
        self._lock = threading.Lock()
        self._authorized: dict[int, int] = {}  # active command → epoch of its lease
        self._seq = itertools.count(1)
        self._driving: Setpoint | None = None  # the last goal setpoint that moved
        self._stood: dict[str, float] = {}  # when a stop or a halt was sent [s], of those since the last command

    def authorize(self, active_command: int, epoch: int) -> None:
        """Let this active command drive from now on, under this lease."""
        with self._lock:
            self._authorized[active_command] = epoch

    def revoke(self, active_command: int) -> None:
        with self._lock:
            self._authorized.pop(active_command, None)

    def follow(self, snapshot: Snapshot) -> None:
        """Send what the pilot asks for; from the pilot's thread."""
        with self._lock:
            last, press = self._driving, snapshot.setpoint_command_id
            epoch = self._authorized.get(press)
            if epoch is not None:
                self._driving = self._send(epoch, press, snapshot.setpoint, snapshot.nonce)
            elif last is not None:
                self._send(last.epoch, last.press, ZERO, snapshot.nonce)
                self._driving = None

    def jog(self, drive: JogMessage) -> None:
        with self._lock:
            self._stood.clear()
            self._robot.send(Setpoint(drive.epoch, drive.seq, "jog", drive.press, drive.v, drive.w, drive.nonce))

    def stop(self) -> None:
        """Zero now; no goal that was authorized until now moves again."""
        self._stand("stop", self._robot.stop)

    def halt(self) -> None:
        """The same, latched."""
        self._stand("halt", self._robot.halt)

    def hand_over(self, epoch: int, owner: str | None) -> None:
        """Through zero to the next operator, or to nobody."""
        with self._lock:
            self._stood.clear()
            self._robot.disarm()
            self._authorized.clear()
            if owner is not None:
                self._robot.arm(epoch, owner)

    def arm(self, epoch: int, owner: str) -> None:
        """Make sure that the gate knows the holder of the lease; changes nothing when it does."""
        with self._lock:
            self._stood.clear()
            self._robot.arm(epoch, owner)

    def _stand(self, kind: str, act: Callable[[], None]) -> None:
        with self._lock:
            self._authorized.clear()
            now = time.monotonic()
            if now - self._stood.get(kind, -REPEATED_STOP_S) >= REPEATED_STOP_S:
                act()
                self._stood[kind] = now

    def _send(self, epoch: int, press: int, twist: Twist, nonce: int) -> Setpoint | None:
        self._stood.clear()
        setpoint = Setpoint(epoch, next(self._seq), "goal", press, twist.v, twist.w, nonce)
        self._robot.send(setpoint)
        return setpoint if twist.moves else None
