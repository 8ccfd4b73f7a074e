"""How long motion outlives its order: faults struck on the running console while a hand holds the drive key.

The time runs from the fault to the gate's first zero, on the one steady clock that all processes share.
"""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from random import Random

import psutil

from core.gate.trace import TraceRow, read_trace
from tests.benchmarks.frozen_link import FrozenLink
from tests.benchmarks.real_sessions import SUBJECTS
from tests.benchmarks.running_console import Console, console, watch
from tests.benchmarks.strangers import own_computer
from tests.emulators.robot_process import RobotProcess, robot_process

START_PATIENCE_S = 60.0
WATCHED_S = 0.8  # after a fault
LOOK_PERIOD_S = 0.002  # between two looks at a trace
MACHINE_CLOCK_NS = 10**9  # within which a row's time is that of this machine
GHOST_S = 1.0  # in which nothing may move after a freeze
JITTER_S = 0.1  # of a link whose frames come late, but come
FLOWING_S = 0.02  # for which it lets through what it kept, at least: else a frame is held up twice


@contextlib.contextmanager
def driven(driver: str) -> Iterator[Console]:
    """A console on `sim:lab`, or on an emulated robot with these wires, that is ready to drive."""
    kinds = SUBJECTS[driver]
    serving: AbstractContextManager[RobotProcess | None] = robot_process(*kinds) if kinds else nullcontext()
    with serving as robot:
        url, environment = (robot.url, robot.environment) if robot is not None else ("sim:lab", {})
        with console(auth=robot is not None, robot=url, environment=environment) as running:
            until(lambda: running.get("/api/state").get("robot", {}).get("link") == "live", START_PATIENCE_S)
            yield running


@contextlib.contextmanager
def hand(running: Console, through: int | None = None) -> Iterator[subprocess.Popen[str]]:
    """A hand that already holds the key, on a computer of its own: else its silence comes before what is struck."""
    ports = (str(running.port), str(through or running.port))
    key = running.keys[:1] if running.signed else ()
    command = [sys.executable, "-m", "tests.benchmarks.operator_hand", *ports, *key]
    with own_computer():
        holding = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert holding.stdout is not None
    assert holding.stdout.readline() == "holding\n"
    try:
        yield holding
    finally:
        with contextlib.suppress(ProcessLookupError):
            holding.send_signal(signal.SIGCONT)
            holding.kill()
        holding.wait()


def moving(trace: Path) -> bool:
    """Whether the newest row moves."""
    rows = read_trace(trace)
    return bool(rows) and (rows[-1].v != 0.0 or rows[-1].w != 0.0)


def until(condition: Callable[[], bool], seconds: float = 15.0) -> None:
    """Raises TimeoutError when it does not come true."""
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            raise TimeoutError
        time.sleep(0.01)


class TraceOnlooker:
    """Reads a trace as it grows. Where the gate has a simulator's clock, a row is as old as its line."""

    def __init__(self, trace: Path) -> None:
        self._trace = trace
        self._rows: list[tuple[int, TraceRow]] = []  # time.monotonic_ns(), by the gate where it has that clock
        self._over = threading.Event()
        self._seen = len(read_trace(trace))
        self._thread = threading.Thread(target=self._look, daemon=True)

    def __enter__(self) -> TraceOnlooker:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()

    def _look(self) -> None:
        size = 0
        while not self._over.wait(LOOK_PERIOD_S):
            grown, now = self._trace.stat().st_size, time.monotonic_ns()
            if grown != size:
                rows = read_trace(self._trace)
                for row in rows[self._seen :]:
                    own = abs(now - row.t_mono_ns) < MACHINE_CLOCK_NS
                    self._rows.append((row.t_mono_ns if own else now, row))
                size, self._seen = grown, len(rows)

    @property
    def last_motion(self) -> int:
        """time.monotonic_ns() of the newest row that moves; 0: none does."""
        return max((at for at, row in list(self._rows) if row.v or row.w), default=0)

    def zero_after(self, struck: int, patience: float = WATCHED_S) -> float:
        """[ms] from the instant `struck` [ns] to the first zero that nothing follows. Raises AssertionError."""
        time.sleep(patience)
        rows = list(self._rows)
        last = max((number for number, (_, row) in enumerate(rows) if row.v or row.w), default=-1)
        assert rows[last + 1 :], "it never stood still"
        zero = rows[last + 1][0]
        assert zero >= struck, "it stood before it was struck"
        return (zero - struck) / 1e6


def strike(running: Console, fault: Callable[[subprocess.Popen[str]], None]) -> float:
    """One trial: hold, strike, wait for zero → [ms]."""
    with hand(running) as holding:
        until(lambda: moving(running.trace))
        time.sleep(0.3)
        with TraceOnlooker(running.trace) as onlooker:
            struck = time.monotonic_ns()
            fault(holding)
            return onlooker.zero_after(struck)


def moves_from(trace: Path, row: int) -> bool:
    return any(one.v or one.w for one in read_trace(trace)[row:])


def closed(driver: str, trials: int) -> list[float]:
    """The browser is killed → [ms] to zero."""
    with driven(driver) as running:
        return [strike(running, lambda holding: holding.kill()) for _ in range(trials)]


def frozen(driver: str, trials: int) -> tuple[list[float], int]:
    """The browser is frozen and thaws → [ms] to zero, and in how many trials it moved after the thaw."""
    times: list[float] = []
    ghosts = 0
    with driven(driver) as running:
        for _ in range(trials):
            with hand(running) as holding:
                until(lambda: moving(running.trace))
                time.sleep(0.3)
                with TraceOnlooker(running.trace) as onlooker:
                    struck = time.monotonic_ns()
                    holding.send_signal(signal.SIGSTOP)
                    times.append(onlooker.zero_after(struck))
                thawed = len(read_trace(running.trace))
                holding.send_signal(signal.SIGCONT)  # the key is still held, and old frames are on their way
                time.sleep(GHOST_S)
                ghosts += moves_from(running.trace, thawed)
    return times, ghosts


def frozen_links(driver: str, trials: int) -> tuple[list[float], int]:
    """A link that keeps all and lets it through when the browser is dead → [ms] to zero, trials that moved again."""
    times: list[float] = []
    ghosts = 0
    with driven(driver) as running, FrozenLink(running.port) as link:
        for _ in range(trials):
            link.flow()
            with hand(running, link.port) as holding:
                until(lambda: moving(running.trace))
                time.sleep(0.3)
                with TraceOnlooker(running.trace) as onlooker:
                    struck = time.monotonic_ns()
                    link.freeze()
                    times.append(onlooker.zero_after(struck))
                holding.kill()
                time.sleep(0.3)
                thawed = len(read_trace(running.trace))
                link.flow()
                time.sleep(GHOST_S)
            ghosts += moves_from(running.trace, thawed)
    return times, ghosts


def false_trips(seconds: float, seed: int) -> int:
    """A link that holds frames up for at most `JITTER_S`, again and again → how often a held key stops driving."""
    chance, trips, end = Random(seed), 0, time.monotonic() + seconds
    with driven("sim") as running, FrozenLink(running.port) as link:
        while time.monotonic() < end:
            with hand(running, link.port):
                until(lambda: moving(running.trace))
                while time.monotonic() < end and moving(running.trace):
                    link.freeze()
                    time.sleep(chance.uniform(0.0, JITTER_S))
                    link.flow()
                    time.sleep(chance.uniform(FLOWING_S, JITTER_S))
                trips += not moving(running.trace)
    return trips


def console_faults(driver: str, trials: int, chosen: signal.Signals) -> list[float]:
    """Faults of the console itself; a new one for every trial → [ms] to zero."""
    times: list[float] = []
    for _ in range(trials):
        with driven(driver) as running:
            times.append(strike(running, lambda _, pid=running.process.pid: os.kill(pid, chosen)))
    return times


def driver_frozen(driver: str, trials: int) -> list[float]:
    """The driver's process is frozen; a new console for every trial → [ms] until the gate asks for zero."""
    times: list[float] = []
    for _ in range(trials):
        with driven(driver) as running:
            children = psutil.Process(running.process.pid).children(recursive=True)
            pid = next(child.pid for child in children if "core.robots.process" in child.cmdline())
            times.append(strike(running, lambda _, pid=pid: os.kill(pid, signal.SIGSTOP)))
    return times


def stops_under_load(driver: str, trials: int, viewers: int) -> list[float]:
    """`POST /api/stop` → zero [ms], with so many viewers and one that never reads."""
    times: list[float] = []
    with driven(driver) as running, contextlib.ExitStack() as stack:
        watch(running, viewers, stack)
        for _ in range(trials):
            with hand(running):
                until(lambda: moving(running.trace))
                time.sleep(0.2)
                with own_computer(), TraceOnlooker(running.trace) as onlooker:
                    struck = time.monotonic_ns()
                    running.post("/api/stop")
                    times.append(onlooker.zero_after(struck, patience=0.2))
    return times
