"""How fast the gate stands: `python -m tests.benchmarks.gate_timing [--trials 20]`, or `pytest -m campaign`.

Driver and gate run as always, on an emulated robot of two wires: the gate of a simulated one has the simulator's
clock. The console's part is played here, or by a process of its own that is killed or frozen. Times run from the
fault to the first zero in the gate's diary, on the one steady clock of the machine. The ticks' gaps come from orders
that change all the time, so that every tick leaves a row. Everything is measured idle and with two busy loops;
"""

import contextlib
import itertools
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from console.robot.supervisor import RobotSupervisor
from core.gate import Limits, Setpoint, TraceRow, check, read_trace
from tests.benchmarks.command import print_row, run_command
from tests.emulators.robot_process import robot_process

ROOT = Path(__file__).resolve().parents[2]
SERIAL_PARTS = ("serial", "scip")
BOUNDS_MS = {"console SIGKILL": 150.0, "console SIGSTOP": 300.0, "jog silence": 300.0, "stop": 25.0, "tick gap": 60.0}
"""On the largest value; on the 99th percentile for `stop`."""


@contextlib.contextmanager
def busy(loops: int) -> Iterator[None]:
    """So many processes that do nothing but count."""
    hogs = [subprocess.Popen([sys.executable, "-S", "-c", "while True: pass"]) for _ in range(loops)]
    try:
        yield
    finally:
        for hog in hogs:
            hog.kill()
            hog.wait()


class Hand:
    """Holds a key in a thread: beats at 20 Hz, orders at 100 Hz, until told otherwise."""

    def __init__(self, robot: RobotSupervisor) -> None:
        self._robot = robot
        self._chance = random.Random(1)
        self._press, self._seq = 1, 0
        self.holds = True
        self.trembles = False
        self.sent = 0.0  # when the last moving order left [s]
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        while not self._over.wait(0.01):
            if self._seq % 5 == 0:
                self._robot.beat()
            self._robot.next_frame(0.0)
            self._seq += 1
            status = self._robot.status()
            v = self._chance.uniform(0.05, 0.2) if self.trembles else 0.1
            if status.need_neutral:
                self._press += 1
                self._order(0.0, 0.0)
            elif self.holds:
                self._order(v, 0.6)
                self.sent = time.monotonic()

    def _order(self, v: float, w: float) -> None:
        nonce = self._robot.status().nonce
        self._robot.send(Setpoint(1, self._seq, "jog", self._press, v, w, nonce))

    def leave(self) -> None:
        """Let go for good."""
        self._over.set()
        self._thread.join()


def first_zero(rows: Sequence[TraceRow], after: float) -> float:
    """When the wheels were first told zero at or after a time [s]."""
    return next(row.t_mono_ns * 1e-9 for row in rows if row.t_mono_ns * 1e-9 >= after and not row.v and not row.w)


def checked(trace: Path) -> list[TraceRow]:
    """The rows of a diary in which nothing is wrong."""
    rows = read_trace(trace)
    assert check(rows, Limits()) == []
    return rows


def console_struck(number: signal.Signals, trials: int) -> list[float]:
    """A console that drives by hand is killed or frozen → times to zero [s]."""
    times: list[float] = []
    for trial in range(trials):
        with tempfile.TemporaryDirectory() as folder, robot_process(*SERIAL_PARTS) as served:
            console = subprocess.Popen(
                [sys.executable, "-m", "tests.console.driving_console", served.url, folder, "jog"],
                cwd=ROOT,
                stdout=subprocess.PIPE,
                text=True,
            )
            assert console.stdout is not None
            children = json.loads(console.stdout.readline())
            console.stdout.readline()
            time.sleep(0.2 + 0.0037 * trial)
            struck = time.monotonic()
            console.send_signal(number)
            time.sleep(0.6)
            times.append(first_zero(checked(Path(folder) / "gate.csv"), struck) - struck)
            console.kill()
            console.wait()
            console.stdout.close()
            while any(os.path.exists(f"/proc/{pid}") for pid in children.values()):
                time.sleep(0.02)
    return times


@contextlib.contextmanager
def driving() -> Iterator[tuple[RobotSupervisor, Hand, Path]]:
    """A robot on its wires, a hand that drives it, and the diary."""
    with tempfile.TemporaryDirectory() as folder, robot_process(*SERIAL_PARTS) as served:
        trace = Path(folder) / "gate.csv"
        robot = RobotSupervisor(served.url, home=Path(folder), gate_trace=trace)
        robot.start()
        robot.arm(1, "hand")
        hand = Hand(robot)
        try:
            yield robot, hand, trace
        finally:
            hand.leave()
            robot.close()


def wait_for_motion(robot: RobotSupervisor) -> None:
    """Until it drives; a few seconds at most."""
    deadline = time.monotonic() + 5.0
    while robot.status().v < 0.09:
        assert time.monotonic() < deadline, robot.status()
        time.sleep(0.005)


def struck_while_driving(strike: Callable[[RobotSupervisor, Hand], float], trials: int) -> list[float]:
    """The hand drives, something happens at the time that `strike` tells → times to zero [s]."""
    moments: list[float] = []
    with driving() as (robot, hand, trace):
        for trial in range(trials):
            hand.holds = True
            wait_for_motion(robot)
            time.sleep(0.1 + 0.0031 * trial)
            moments.append(strike(robot, hand))
            time.sleep(0.4)
        rows = checked(trace)
    return [first_zero(rows, moment) - moment for moment in moments]


def let_silence_fall(robot: RobotSupervisor, hand: Hand) -> float:
    """The hand's frames stop coming; its console lives on."""
    hand.holds = False
    time.sleep(0.02)
    return hand.sent


def stop(robot: RobotSupervisor, hand: Hand) -> float:
    now = time.monotonic()
    robot.stop()
    return now


def tick_gaps(seconds: float) -> list[float]:
    """The hand trembles, so that every tick leaves a row → gaps between ticks [s]."""
    with driving() as (robot, hand, trace):
        hand.trembles = True
        wait_for_motion(robot)
        begun = time.monotonic()
        time.sleep(seconds)
        rows = [row for row in checked(trace) if row.t_mono_ns * 1e-9 > begun and not row.event]
    stamps = [row.t_mono_ns * 1e-9 for row in rows]
    return [b - a for a, b in itertools.pairwise(stamps)]


def campaign(trials: int, seconds: float) -> dict[str, dict[str, list[float]]]:
    """Load → measurement → times [ms]."""
    told: dict[str, dict[str, list[float]]] = {}
    for load, loops in (("idle", 0), ("2 busy loops", 2)):
        with busy(loops):
            times = {
                "console SIGKILL": console_struck(signal.SIGKILL, trials),
                "console SIGSTOP": console_struck(signal.SIGSTOP, trials),
                "jog silence": struck_while_driving(let_silence_fall, trials),
                "stop": struck_while_driving(stop, trials),
                "tick gap": tick_gaps(seconds),
            }
        told[load] = {name: [round(1000 * t, 2) for t in measured] for name, measured in times.items()}
    return told


def quantile(values: Sequence[float], part: float) -> float:
    """The value below which `part` (0..1) of the values lie."""
    return sorted(values)[min(int(part * len(values)), len(values) - 1)]


def table(told: dict[str, dict[str, list[float]]]) -> str:
    """The figures as people read them."""
    lines = [f"{'':14}{'':18}{'n':>6}{'p50':>8}{'p99':>8}{'max':>8}{'bound':>8}  [ms]"]
    for load, measured in told.items():
        for name, times in measured.items():
            figures = (quantile(times, 0.5), quantile(times, 0.99), max(times), BOUNDS_MS[name])
            lines.append(f"{load:14}{name:18}{len(times):6}" + "".join(f"{figure:8.1f}" for figure in figures))
    return "\n".join(lines)


def main(
    *,
    trials: int = 20,
    seconds: float = 20.0,  # of ticks
) -> None:
    told = campaign(trials, seconds)
    print_row(table(told))


if __name__ == "__main__":
    run_command(main)
