"""The gate's own process: `python -m core.gate.process`. Standard library only, so nothing can make it late.

From the console: setpoints, stops, and its heartbeat. From the driver: near points. To the driver: the twist with the
newest nonce, every tick. When the console is gone it sends zeros for two seconds and ends.
"""

import argparse
import json
import math
import os
import secrets
import selectors
import signal
import socket
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import NoReturn

from core.errors import BadInput
from core.gate import requests
from core.gate.gate import TICK_S, Gate
from core.gate.latch import Latch
from core.gate.limits import Limits, is_count
from core.gate.packets import packet_socket, send_packet, take_packets
from core.gate.scheduling import GATE_RANK, stay_first
from core.gate.setpoint import Setpoint
from core.gate.simulated_clock import SimulatedClock
from core.gate.status import GateStatus
from core.gate.suspend import SleepWatch, time_asleep
from core.gate.trace import TraceWriter, open_trace
from core.gate.twist import ZERO

FAREWELL_S = 2.0  # of zeros when the console is gone
REST_TICKS = round(2.0 / TICK_S)  # of standing, after which zeros go out with every second tick only
PARENT_CHECK_S = 1.0  # between looks whether the console still is this process's parent
FIRST_NONCE = 2**50  # a random number below it, so that no nonce of an earlier gate is ever valid again


class GateLoop:
    """Ticks at 50 Hz by absolute deadlines and answers between ticks as soon as something comes."""

    def __init__(
        self,
        gate: Gate,
        latch: Latch,
        console: socket.socket,
        driver: socket.socket,
        asleep: Callable[[], float] = time_asleep,
        simulated: SimulatedClock | None = None,
    ) -> None:
        """`simulated`: the clock of a simulated robot; None: the robot is real, and so is its time."""
        self._gate, self._latch = gate, latch
        self._simulated = simulated
        self._sleep = SleepWatch(asleep)
        self._console, self._driver = console, driver
        self._ends_at: float | None = None
        self._sent_twist = ZERO
        self._sent_status: GateStatus | None = None
        self._ticks = self._busy_tick = 0  # ticks until now; until a setpoint came or something moved
        self._kept = False  # whether the latch was set by this process
        self._latched = 0  # number of the newest halt that is on disk
        self._selector = selectors.DefaultSelector()
        self._selector.register(console, selectors.EVENT_READ, self._hear_console)
        self._selector.register(driver, selectors.EVENT_READ, self._hear_driver)

    def run(self) -> None:
        """Run until the console is gone and zeros have been sent to the robot for a while."""
        parent, due, looked = os.getppid(), time.monotonic(), time.monotonic()
        try:
            while True:
                wait = min(due, self._expires) - time.monotonic()
                events = self._selector.select(max(0.0, wait))
                self._look_for_sleep()
                for key, _ in events:
                    key.data()
                now = time.monotonic()
                if now >= min(due, self._expires):
                    self._tick(now if self._simulated is None else self._simulated.advance(now))
                if now >= due:
                    due = due + TICK_S if now - due < TICK_S else now + TICK_S
                if now - looked > PARENT_CHECK_S:
                    looked = now
                    if os.getppid() != parent:
                        self._console_gone()
                if self._ends_at is not None and now >= self._ends_at:
                    return
        finally:
            self._gate.disarm(self._now, "the gate ends")
            self._tell_driver()

    @property
    def _now(self) -> float:
        return time.monotonic() if self._simulated is None else self._simulated.now

    @property
    def _expires(self) -> float:
        """Real time [s] at which a tick is due for the setpoint's sake; a simulated clock stands between ticks."""
        return self._gate.expires if self._simulated is None else math.inf

    @property
    def _rests(self) -> bool:
        return self._ticks - self._busy_tick > REST_TICKS

    def _look_for_sleep(self) -> None:
        if self._sleep.woke():
            self._gate.wake(self._now)
            self._tell_driver()
            self._tell_console(always=True)

    def _tick(self, now: float) -> None:
        self._ticks += 1
        if self._gate.tick(now).moves:
            self._busy_tick = self._ticks
        if not self._rests or self._ticks % 2 == 0:
            self._tell_driver()
        self._tell_console(always=self._ticks % 2 == 0)

    def _hear_console(self) -> None:
        packets, there = take_packets(self._console)
        for packet in packets:
            if (request := requests.read_request(packet)) is not None:
                self._answer(request, self._now)
            if self._gate.twist != self._sent_twist and not self._gate.twist.moves:
                self._tell_driver()
        if not there:
            self._console_gone()
        self._tell_console(always=False)

    def _hear_driver(self) -> None:
        packets, there = take_packets(self._driver)
        now = self._now
        for packet in packets:
            report = requests.read_report(packet)
            if self._simulated is not None and report.stamp is not None:
                self._simulated.report(report.stamp, time.monotonic())
            if report.points is not None:
                self._gate.see(report.points, now, report.field, report.age or 0.0)
            elif report.age is not None:
                self._gate.see_untimely(report.age, now)
            if report.trouble:
                self._gate.see_trouble(now)
            self._gate.touch(report.contact, now)
        if not there:
            self._selector.unregister(self._driver)
            self._gate.disarm(now, "the robot's driver is gone")
            self._ends_at = time.monotonic() if self._ends_at is not None else None
        if not self._gate.twist.moves and self._sent_twist.moves:
            self._tell_driver()
        self._tell_console(always=False)

    def _answer(self, request: requests.GateRequest, now: float) -> None:
        match request:
            case Setpoint():
                self._busy_tick = self._ticks
                self._gate.accept(request, now)
            case requests.GateHeartbeat() | requests.GateReach():
                self._hear_sign(request, now)
            case requests.GateStop():
                self._gate.stop(now)
            case requests.GateHalt(number):
                self._halt(number, now)
            case requests.GateReset():
                self._reset(now)
            case requests.GateArm(epoch, owner):
                self._gate.arm(epoch, owner, now)
            case requests.GateDisarm():
                self._gate.disarm(now)
            case requests.GateCap(speed):
                self._gate.cap(speed)
            case requests.GateLeave():
                self._leave(now)

    def _hear_sign(self, sign: requests.GateHeartbeat | requests.GateReach, now: float) -> None:
        """The console is alive, or its pilot has come so far."""
        if isinstance(sign, requests.GateHeartbeat):
            self._gate.heartbeat(now)
        if self._simulated is not None:
            self._simulated.hear(sign)

    def _halt(self, number: int, now: float) -> None:
        """Set zero first, then the latch on disk; only then tell the console that the robot is halted."""
        self._gate.halt(now)
        self._tell_driver()
        try:
            if not self._kept:
                self._latch.set()
        except OSError as trouble:
            self._gate.remark(f"halted, but a restart may forget it: {trouble.strerror}")
            return
        self._kept = True
        self._latched = number

    def _reset(self, now: float) -> None:
        self._kept, self._latched = False, 0
        try:
            self._latch.clear()
        except OSError as trouble:
            self._gate.remark(f"the halt could not be lifted: {trouble.strerror}")
            return
        self._gate.reset(now)

    def _leave(self, now: float) -> None:
        self._gate.disarm(now, "the console ends")
        self._tell_driver()
        self._ends_at = time.monotonic()

    def _console_gone(self) -> None:
        if self._ends_at is None:
            self._gate.disarm(self._now, "the console is gone")
            self._tell_driver()
            self._ends_at = time.monotonic() + FAREWELL_S
            self._selector.unregister(self._console)

    def _tell_driver(self) -> None:
        twist = self._sent_twist = self._gate.twist
        packet: dict[str, object] = {"v": twist.v, "w": twist.w, "nonce": self._gate.nonce}
        if self._simulated is not None and (until := self._simulated.until) is not None:
            packet["until"] = until + (TICK_S if self._rests else 0.0)  # which is then said half as often
        send_packet(self._driver, packet)

    def _tell_console(self, *, always: bool) -> None:
        status, sent = replace(self._gate.status(), latched=self._latched), self._sent_status
        if always or sent is None or status != replace(sent, nonce=status.nonce):
            self._sent_status = status
            send_packet(self._console, status.to_packet())


def _spent(text: str) -> list[tuple[str, int]]:
    """The presses of an earlier gate, as JSON pairs."""
    return [(str(source), press) for source, press in json.loads(text) if is_count(press)]


def _end(number: int, frame: object) -> NoReturn:
    """A polite request to end: through zero."""
    del number, frame
    raise SystemExit(0)


def main(arguments: list[str] | None = None) -> None:
    """Run the gate on the descriptors that the console passed on."""
    parser = argparse.ArgumentParser(prog="core.gate.process")
    parser.add_argument("--console", type=int, required=True, help="descriptor of the pipe to the console")
    parser.add_argument("--driver", type=int, required=True, help="descriptor of the pipe to the driver")
    parser.add_argument("--home", type=Path, required=True, help="folder that remembers a halt")
    parser.add_argument("--limits", default="{}", help="JSON")
    parser.add_argument("--spent", default="[]", help="presses of an earlier gate, JSON")
    parser.add_argument("--halted", action="store_true", help="begin halted whatever the home folder remembers")
    parser.add_argument("--trace", type=Path, help="file for the trace")
    parser.add_argument(
        "--simulated", type=float, help="seconds between frames of a simulated robot, whose time counts"
    )
    given = parser.parse_args(arguments)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _end)
    stay_first(GATE_RANK)
    latch = Latch(given.home)
    try:
        limits = Limits.of(json.loads(given.limits))
        line_writer = open_trace(given.trace) if given.trace else None
    except (BadInput, ValueError, OSError) as trouble:
        raise SystemExit(f"The gate does not start: {trouble}") from None
    trace = TraceWriter(line_writer) if line_writer else None
    simulated = SimulatedClock(given.simulated) if given.simulated else None
    gate = Gate(
        limits,
        halted=given.halted or latch.is_set,
        trace=trace,
        first_nonce=secrets.randbelow(FIRST_NONCE),
        spent=_spent(given.spent),
    )
    if trace is not None:
        trace.write(gate.status(), 0, "boot", time.monotonic() if simulated is None else simulated.now)
    try:
        console, driver = packet_socket(given.console), packet_socket(given.driver)
        GateLoop(gate, latch, console, driver, simulated=simulated).run()
    finally:
        if line_writer is not None:
            line_writer.close()


if __name__ == "__main__":
    main()
