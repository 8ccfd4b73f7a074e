"""Stop, halt (a latched stop in software, no emergency stop) and halt reset.

Every stop acts; a flood of them leaves few rows in the history.
"""

import asyncio
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from console.access.logins import Person
from console.control.command_freshness import EARS
from console.control.history import History
from console.control.lease import Lease
from console.control.notices import Notifications
from console.http.problems import Problem
from console.http.rate_counter import RateCounter
from console.robot.setpoint_sender import SetpointSender
from console.robot.supervisor import RobotSupervisor
from core.errors import Unavailable
from core.gate.status import GateStatus
from core.sentences import Statement
from core.snapshot import Ending

MAX_RECORDED_STOPS = 3  # stops and halts of one person a second that are written down; all of them act
MAX_PEOPLE = 1000  # whose stops are counted
SAME_PRESS_S = 2.0  # within which a press of STOP comes by its second way, and is not written down again
MAX_LATCHING_S = 0.2  # that the gate may take to latch a halt before the console does
LOOK_PERIOD_S = 0.002
CAUSE = "halt"  # of the notices about a halt: the newest replaces the others
MAX_LIFTING_S = 1.0  # within which a reset must show


@dataclass
class HaltReset:
    """A reset that was sent and does not show yet."""

    who: Person
    entry: int
    sent: float  # [s]


class StopController:
    """`cancel(state, why, who)` ends the active command."""

    def __init__(
        self,
        robot: RobotSupervisor,
        setpoint_sender: SetpointSender,
        lease: Lease,
        history: History,
        notifications: Notifications,
        cancel: Callable[[Ending, str, Person], None],
    ) -> None:
        self._robot = robot
        self._setpoint_sender = setpoint_sender
        self._lease = lease
        self._history = history
        self._notifications = notifications
        self._cancel = cancel
        self._tallies: dict[str, RateCounter] = {}  # by person
        self._presses: deque[tuple[str, int, float]] = deque(maxlen=64)  # the newest: person, press, when [s]
        self._lifting: HaltReset | None = None

    def stop(self, who: Person, source: str, press: int = 0) -> None:
        """Everything cancelled, zero speed, always. A press that comes by a second way is recorded once."""
        self._setpoint_sender.stop()
        why = Statement("stop.heard") if source == EARS else Statement("stop.stopped_by", name=who.name)
        self._cancel("cancelled", why, who)
        if self._is_recorded(who, press):
            self._history.add("stop", who, source=source)

    def halt(self, who: Person, source: str, press: int = 0) -> None:
        """The same, latched; the function `latched` waits until it is on disk."""
        self._lifted("cancelled", Statement("stop.halted_again"))
        self._setpoint_sender.halt()
        self._cancel("cancelled", Statement("stop.halted_by", name=who.name), who)
        if self._is_recorded(who, press):
            self._history.add("halt", who, source=source)
            self._notifications.tell("warning", Statement("stop.who_halted", name=who.name), CAUSE)

    def reset(self, who: Person, source: str) -> None:
        """Lift the latch; the lease holder only, and it never moves. Raises Problem 403, 409, 503."""
        if not who.may("operator"):
            raise Problem(403, Statement("stop.only_operators_reset"))
        if self._robot.status().state != "halted":
            raise Problem(409, Statement("stop.not_halted"))
        self._lease.acquire(who, time.monotonic())
        if not self._robot.reset():
            raise Problem(503, Statement("stop.no_gate"))
        self._setpoint_sender.hand_over(self._lease.epoch, who.name)
        self._lifted("cancelled", Statement("stop.reset_again"))
        entry = self._history.add("halt_reset", who, state="running", source=source)
        self._lifting = HaltReset(who, entry.id, time.monotonic())

    def tick(self, status: GateStatus, now: float) -> None:
        """Say of a reset whether the gate obeyed it."""
        lifting = self._lifting
        if lifting is None:
            return
        if status.state != "halted":
            self._lifted("done", "")
            self._notifications.tell("info", Statement("stop.who_reset", name=lifting.who.name), CAUSE)
        elif now - lifting.sent > MAX_LIFTING_S:
            self._lifted("failed", status.reason)
            self._notifications.tell("error", Statement("stop.still_halted", reason=status.reason), CAUSE)

    def _lifted(self, state: str, remark: str) -> None:
        lifting, self._lifting = self._lifting, None
        if lifting is not None:
            self._history.end(lifting.entry, state, remark)

    def _is_recorded(self, who: Person, press: int) -> bool:
        now = time.monotonic()
        known = any((of, one) == (who.id, press) and now - at < SAME_PRESS_S for of, one, at in self._presses)
        if press:
            self._presses.append((who.id, press, now))
        if known:
            return False
        if who.id not in self._tallies and len(self._tallies) >= MAX_PEOPLE:
            self._tallies.clear()
        return self._tallies.setdefault(who.id, RateCounter()).add(now) <= MAX_RECORDED_STOPS


async def latched(robot: RobotSupervisor, notifications: Notifications) -> str:
    """Wait until the newest halt is on disk → "", or why a restart may forget it."""
    ends = time.monotonic() + MAX_LATCHING_S
    while not robot.halt_is_latched() and time.monotonic() < ends:
        await asyncio.sleep(LOOK_PERIOD_S)
    try:
        if not robot.halt_is_latched():
            await asyncio.to_thread(robot.latch_halt)
    except Unavailable as trouble:
        why = f"The robot is halted, but a restart of the console may forget it. {trouble}"
        notifications.tell("error", why)
        return why
    return "" if robot.halt_is_latched() else Statement("stop.reset_meanwhile")
