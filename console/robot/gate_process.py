"""A running gate: its process, the messages to it, and its answers."""

import json
import time
from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path

from console.robot.driver_process import DriverProcess
from console.workers.child_process import ChildProcess
from core.errors import BadInput, Unavailable
from core.gate import GateStatus, Limits
from core.gate.packets import packet_pair, send_packet, take_packets
from core.robots import Profile


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

    def read(self) -> tuple[list[GateStatus], bool]:
        """Take the gate's messages, without waiting, and check that it is still there."""
        packets, there = take_packets(self.requests)
        if packets:
            self.heard, self.started = time.monotonic(), True
        return [GateStatus.of_packet(packet) for packet in packets[-1:]], there

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
