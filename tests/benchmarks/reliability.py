"""How long motion outlives its order, measured on the running console: `python -m tests.benchmarks.reliability`.

Every fault is struck while a hand holds the drive key. The time runs from the fault to the gate's first zero, on the
one steady clock that all processes share. Everything is measured idle and with two busy loops.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import signal
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from websockets.sync.client import connect

from core.gate.trace import read_trace
from tests.benchmarks.frozen_link import FrozenLink
from tests.benchmarks.running_console import Console, console

BOUNDS_MS = {
    "browser socket closed": 100,
    "browser frozen": 300,
    "console SIGKILL": 150,
    "console SIGSTOP": 300,
    "stop with 20 viewers and one stuck": 25,
}


@contextlib.contextmanager
def hand(port: int, through: int | None = None) -> Iterator[subprocess.Popen[str]]:
    """A hand that already holds the key."""
    command = [sys.executable, "-m", "tests.benchmarks.operator_hand", str(port), str(through or port)]
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


def wait_until(condition: Callable[[], bool], seconds: float = 5.0) -> None:
    """Raises TimeoutError when it does not come true."""
    end = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > end:
            raise TimeoutError
        time.sleep(0.01)


def zero_after(trace: Path, struck: int, patience: float = 0.8) -> float:
    """[ms] from the instant `struck` [ns] to the first zero that nothing follows."""
    time.sleep(patience)
    rows = read_trace(trace)
    moved = [row.t_mono_ns for row in rows if row.v != 0.0 or row.w != 0.0]
    still = [row.t_mono_ns for row in rows if row.t_mono_ns > moved[-1] and row.v == 0.0 == row.w]
    if not still:
        raise AssertionError("it never stood still")
    return max(0.0, (still[0] - struck) / 1e6)


def strike(running: Console, fault: Callable[[subprocess.Popen[str]], None]) -> float:
    """One trial: hold, strike, wait for zero → [ms]."""
    with hand(running.port) as holding:
        wait_until(lambda: moving(running.trace))
        time.sleep(0.3)
        struck = time.monotonic_ns()
        fault(holding)
        return zero_after(running.trace, struck)


def viewer_faults(trials: int) -> dict[str, list[float]]:
    """Faults of the browser's side; the console goes on. Also counts ghosts: motion after a freeze ends."""
    closed: list[float] = []
    frozen: list[float] = []
    ghosts: list[float] = []
    with console() as running:
        for _ in range(trials):
            closed.append(strike(running, lambda holding: holding.kill()))
        for _ in range(trials):
            with hand(running.port) as holding:
                wait_until(lambda: moving(running.trace))
                time.sleep(0.3)
                struck = time.monotonic_ns()
                holding.send_signal(signal.SIGSTOP)
                frozen.append(zero_after(running.trace, struck))
                thawed = time.monotonic_ns()
                holding.send_signal(signal.SIGCONT)  # the key is still held, and old frames are on their way
                time.sleep(1.0)
                rows = read_trace(running.trace)
                ghosts.append(float(any(row.t_mono_ns > thawed and (row.v or row.w) for row in rows)))
    return {"browser socket closed": closed, "browser frozen": frozen, "ghost motion (trials)": ghosts}


def buffered_frames(trials: int) -> list[float]:
    """A link that lets all it kept through when the browser is dead → 1 for each trial that moved."""

    moved: list[float] = []
    with console() as running, FrozenLink(running.port) as link:
        for _ in range(trials):
            link.flow()
            with hand(running.port, link.port) as holding:
                wait_until(lambda: moving(running.trace))
                link.freeze()
                time.sleep(1.0)
                holding.kill()
                time.sleep(0.3)
                thawed = time.monotonic_ns()
                link.flow()
                time.sleep(1.0)
            rows = read_trace(running.trace)
            moved.append(float(any(row.t_mono_ns > thawed and (row.v or row.w) for row in rows)))
    return moved


def console_faults(trials: int, chosen: signal.Signals) -> list[float]:
    """Faults of the console itself; a new one for every trial."""
    found: list[float] = []
    for _ in range(trials):
        with console() as running:
            found.append(strike(running, lambda _, pid=running.process.pid: os.kill(pid, chosen)))
    return found


def stops_under_load(trials: int) -> list[float]:
    """`POST /api/stop` → zero, with 20 viewers and one that never reads."""
    found: list[float] = []
    with console() as running, contextlib.ExitStack() as stack:
        watch(running.port, 20, stack)
        for _ in range(trials):
            with hand(running.port):
                wait_until(lambda: moving(running.trace))
                time.sleep(0.2)
                struck = time.monotonic_ns()
                running.post("/api/stop")
                found.append(zero_after(running.trace, struck, patience=0.2))
    return found


def watch(port: int, viewers: int, stack: contextlib.ExitStack) -> None:
    """`viewers` sockets that read everything and one that reads nothing."""
    url, origin = f"ws://127.0.0.1:{port}/ws", f"http://127.0.0.1:{port}"

    def read(socket: object) -> None:
        with contextlib.suppress(Exception):
            for _ in socket:  # type: ignore[attr-defined]
                pass

    for number in range(viewers + 1):
        socket = connect(url, origin=origin, compression=None, ping_interval=None)  # type: ignore[arg-type]
        stack.callback(socket.socket.close)
        if number < viewers:
            threading.Thread(target=read, args=(socket,), daemon=True).start()


@contextlib.contextmanager
def busy_loops(count: int) -> Iterator[None]:
    """Processes that burn a core each."""
    burning = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(count)]
    try:
        yield
    finally:
        for process in burning:
            process.kill()
            process.wait()


def summary(values: list[float]) -> dict[str, float]:
    """Median, p99 and max."""
    ordered = sorted(values)
    return {
        "trials": len(ordered),
        "median": round(statistics.median(ordered), 1),
        "p99": round(ordered[min(len(ordered) - 1, int(0.99 * len(ordered)))], 1),
        "max": round(ordered[-1], 1),
    }


def campaign(trials: int) -> dict[str, dict[str, dict[str, float]]]:
    """All faults, idle and with two busy loops."""
    found: dict[str, dict[str, dict[str, float]]] = {}
    for load, hogs in (("idle", 0), ("two busy loops", 2)):
        sys.stderr.write(f"{load}…\n")
        with busy_loops(hogs):
            measured = viewer_faults(trials)
            measured["ghost motion through a thawed link (trials)"] = buffered_frames(trials)
            measured["console SIGKILL"] = console_faults(trials, signal.SIGKILL)
            measured["console SIGSTOP"] = console_faults(trials, signal.SIGSTOP)
            measured["stop with 20 viewers and one stuck"] = stops_under_load(2 * trials)
            found[load] = {name: summary(values) for name, values in measured.items()}
    return found


def main() -> None:
    """Print the table; write it to reports/reliability.json."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=20)
    found = campaign(parser.parse_args().trials)
    Path("reports").mkdir(exist_ok=True)
    Path("reports/reliability.json").write_text(json.dumps({"bounds_ms": BOUNDS_MS, "measured_ms": found}, indent=1))
    for load, faults in found.items():
        for name, figures in faults.items():
            sys.stdout.write(f"{load:16}{name:46}{figures}\n")


if __name__ == "__main__":
    main()
