"""A running gate: its process, the messages to it, and its answers; and a halt, which outlasts it."""

import json
import logging
import time
from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path

from console.robot.driver_process import DriverProcess
from console.workers.child_process import ChildProcess
from core.errors import BadInput, Unavailable
from core.gate import GateStatus, Limits
from core.gate.latch import Latch
from core.gate.packets import packet_pair, send_packet, take_packets
from core.robots import Profile

log = logging.getLogger(__name__)


class GateProcess:
    """Started by making one, disarmed or halted. `spent` presses are those that an earlier gate has seen."""

    def __init__(
        self,
        driver: DriverProcess,
        limits: Limits,
        home: Path,
        *,
        trace: Path | None,
        spent: Mapping[str, int],
        halted: bool = False,
        simulated: float | None = None,
    ) -> None:
        """`halted`: it begins halted, even if the latch in `home` is lifted. `simulated`: time [s] between
        two frames of a simulated robot, by whose clock the gate lives; None: the robot is real.
        """
        self.requests, theirs = packet_pair()
        with theirs, driver.gate_end() as driver_end:
            arguments = [
                f"--console={theirs.fileno()}",
                f"--driver={driver_end.fileno()}",
                f"--home={home.absolute()}",
                f"--limits={json.dumps(asdict(limits))}",
                f"--spent={json.dumps(list(spent.items()))}",
                *([f"--trace={trace.absolute()}"] if trace else []),
                *(["--halted"] if halted else []),
                *([f"--simulated={simulated}"] if simulated else []),
            ]
            self.child = ChildProcess("core.gate.process", arguments, (theirs, driver_end), bare=True)
        self.heard = time.monotonic()  # when it spoke last, or was started
        self.started = False  # whether it has spoken

    def send(self, packet: Mapping[str, object]) -> bool:
        """Without waiting → whether it is on its way."""
        return send_packet(self.requests, packet)

    def read(self) -> tuple[GateStatus | None, bool]:
        """Take the gate's messages, without waiting → the newest, and whether the gate is still there."""
        packets, there = take_packets(self.requests)
        if packets:
            self.heard, self.started = time.monotonic(), True
        return GateStatus.of_packet(packets[-1]) if packets else None, there

    def end(self, patience: float) -> None:
        """Through zero and away, by force after `patience` [s]."""
        self.send({"kind": "leave"})
        self.child.end(patience)
        self.requests.close()


def limits_of(profile: Profile, limits: Limits) -> Limits:
    """The tighter of the operator's and the robot's limits; no guard without eyes. Raises Unavailable."""
    try:
        return replace(
            limits,
            max_speed=min(limits.max_speed, profile.max_speed),
            max_turn_rate=min(limits.max_turn_rate, profile.max_turn_rate),
            radius=profile.radius,
            guard=limits.guard and profile.laser is not None,
        )
    except BadInput as trouble:
        raise Unavailable(f"This robot does not fit the gate: {trouble}") from None


class HaltRequest:
    """A halt that was requested: it holds for every later gate, whether or not the present one heard it.

    `asked` from the halt to its reset. The gate sets the latch itself; when it could not, this does.

    Halts are numbered, so that the latch of an earlier one is never taken for that of the newest.
    """

    def __init__(self, home: Path) -> None:
        self.asked = False
        self.number = 0  # of the newest halt
        self._kept = 0  # number of the newest halt that was latched from here
        self._latch = Latch(home)

    @property
    def stands(self) -> bool:
        """True if the next gate begins halted."""
        return self.asked or self._latch.is_set

    def keep(self) -> None:
        """Set the latch. Raises Unavailable when it cannot be kept."""
        try:
            self._latch.set()
        except OSError as trouble:
            raise Unavailable(f"The halt could not be saved: {trouble.strerror}.") from None
        self._kept = self.number

    def is_latched(self, by_gate: int) -> bool:
        """Return whether the newest halt is on disk, when the gate has latched those up to `by_gate`."""
        return self.asked and max(by_gate, self._kept) >= self.number > 0

    def ask(self) -> int:
        """Another halt → its number."""
        self.asked = True
        self.number += 1
        return self.number

    def outlast(self) -> None:
        """The gate is gone: a halt that it did not write down is written now."""
        if not self.asked:
            return
        try:
            self.keep()
        except Unavailable as trouble:
            log.error("%s A restart of the console may forget it.", trouble)
