"""A halt that was answered outlives the death of everything: `python -m tests.benchmarks.halt_kills [--trials 200]`.

Each trial starts a console, halts by POST, sends SIGKILL to console, gate and driver at the same time, 0 to 50 ms
after the halt was sent (or after its answer), and looks whether the next start would be halted. A halt that got no
answer promises nothing.
"""

import contextlib
import os
import random
import signal
import tempfile
import threading
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from http.client import HTTPException
from pathlib import Path
from typing import Any

import psutil

from core.gate.latch import Latch
from tests.benchmarks.command import run_command
from tests.benchmarks.running_console import Console

MAX_DELAY_S = 0.05


def kill_all(console: Console) -> None:
    """SIGKILL to the console and everything that it started, without waiting in between."""
    for pid in [console.process.pid, *(child.pid for child in console.children)]:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)


def halt(console: Console, answers: list[Any]) -> None:
    """POST /api/halt; a whole answer of 200 is noted."""
    with contextlib.suppress(OSError, ValueError, HTTPException):
        answers.append(console.answer("/api/halt"))


def trial(console: Console, home: Path, delay: float) -> str:
    """One halt → "kept", "forgotten", "said unlatched" or "unanswered"."""
    answers: list[Any] = []
    asking = threading.Thread(target=halt, args=(console, answers))
    asking.start()
    time.sleep(delay)
    kill_all(console)
    asking.join()
    console.process.wait()
    psutil.wait_procs(console.children, 5)
    if not answers:
        return "unanswered"
    if answers[0].get("latched") is False:
        return "said unlatched"
    return "kept" if Latch(home).is_set else "forgotten"


def campaign(trials: int, seed: int, *, after_answer: bool) -> Counter[str]:
    """How the halts of so many consoles fared; `after_answer`: the delay begins with the answer."""
    chance, outcomes = random.Random(seed), Counter[str]()
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(1) as ahead:
        homes = [Path(folder) / str(number) for number in range(trials)]
        coming = ahead.submit(begin, homes[0])
        for number, home in enumerate(homes):
            console = coming.result()
            if number + 1 < trials:
                coming = ahead.submit(begin, homes[number + 1])
            delay = chance.uniform(0.0, MAX_DELAY_S)
            outcomes[after(console, home, delay) if after_answer else trial(console, home, delay)] += 1
    return outcomes


def after(console: Console, home: Path, delay: float) -> str:
    """One halt that is answered, then the end."""
    told = console.answer("/api/halt")
    time.sleep(delay)
    kill_all(console)
    console.process.wait()
    psutil.wait_procs(console.children, 5)
    if told.get("latched") is False:
        return "said unlatched"
    return "kept" if Latch(home).is_set else "forgotten"


def begin(home: Path) -> Console:
    home.mkdir()
    return Console(home)


def main(*, trials: int = 200, seed: int = 1) -> object:
    half = trials // 2
    return {
        "killed after the halt was sent": campaign(trials - half, seed, after_answer=False),
        "killed after the answer": campaign(half, seed + 1, after_answer=True),
    }


if __name__ == "__main__":
    run_command(main)
