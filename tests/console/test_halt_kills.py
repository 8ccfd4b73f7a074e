"""A halt that was answered outlives the death of everything; the campaign is `tests.benchmarks.halt_kills`."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from core.gate.latch import Latch

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize(
    ("delay", "fate"),
    [
        (0.0, "gate frozen"),
        (0.01, "well"),
        pytest.param(0.0, "well", marks=pytest.mark.campaign),
        pytest.param(0.01, "gate frozen", marks=pytest.mark.campaign),
    ],
)
def test_a_halt_that_was_answered_outlives_the_death_of_everything(tmp_path: Path, delay: float, fate: str) -> None:
    console = subprocess.Popen(
        [sys.executable, "-m", "tests.console.halting_console", str(tmp_path)],
        cwd=ROOT,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert console.stdin is not None and console.stdout is not None
    pids = json.loads(console.stdout.readline())
    if fate == "gate frozen":
        os.kill(pids["gate"], signal.SIGSTOP)
    console.stdin.write("halt\n")
    console.stdin.flush()
    answer = json.loads(console.stdout.readline())
    time.sleep(delay)
    family = psutil.Process(console.pid).children(recursive=True)  # a gate that was slow may have been replaced
    for pid in (console.pid, *(child.pid for child in family)):
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
    console.wait()
    console.stdin.close()
    console.stdout.close()
    assert answer == {"latched": True}
    assert Latch(tmp_path).is_set
