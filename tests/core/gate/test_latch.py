"""A halt survives everything, whatever moment the process dies at."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from core.gate.latch import NAME, Latch

ROOT = Path(__file__).resolve().parents[3]
TOGGLE = """
import sys, time
from pathlib import Path
from core.gate.latch import Latch

def say(word):
    sys.stdout.write(word)
    sys.stdout.flush()

latch = Latch(Path(sys.argv[1]))
while True:
    say("s")
    latch.set()
    say("+")
    time.sleep(0.002)
    say("c")
    latch.clear()
    say("-")
    time.sleep(0.002)
"""


def test_it_is_set_until_it_is_cleared(tmp_path: Path) -> None:
    latch = Latch(tmp_path / "home")
    assert not latch.is_set
    latch.set()
    assert latch.is_set and Latch(tmp_path / "home").is_set
    latch.clear()
    assert not latch.is_set
    latch.clear()


def test_file_and_folder_are_on_disk_before_it_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    synced: list[str] = []
    monkeypatch.setattr(os, "fsync", lambda number: synced.append(os.readlink(f"/proc/self/fd/{number}")))
    Latch(tmp_path).set()
    assert synced == [str(tmp_path / "halt.new"), str(tmp_path)]
    Latch(tmp_path).clear()
    assert synced[2:] == [str(tmp_path)]


def test_whatever_the_file_says_it_is_a_halt(tmp_path: Path) -> None:
    (tmp_path / NAME).write_bytes(b"\xff\x00 {not json")
    assert Latch(tmp_path).is_set


def test_a_link_to_nowhere_is_a_halt(tmp_path: Path) -> None:
    (tmp_path / NAME).symlink_to(tmp_path / "nowhere")
    assert Latch(tmp_path).is_set


def test_a_home_that_cannot_be_looked_into_is_a_halt(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    assert Latch(tmp_path / "file").is_set


def test_a_halt_that_cannot_be_kept_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(OSError):
        Latch(tmp_path / "file").set()


def test_kill_9_around_the_write_loses_no_halt_that_was_acknowledged(tmp_path: Path) -> None:
    chance = random.Random(3)
    for trial in range(8):
        home = tmp_path / str(trial)
        process = subprocess.Popen(
            [sys.executable, "-S", "-c", TOGGLE, str(home)],
            cwd=ROOT,
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            stdout=subprocess.PIPE,
        )
        assert process.stdout is not None
        process.stdout.read(1)
        time.sleep(chance.uniform(0.0, 0.05))
        process.send_signal(signal.SIGKILL)
        said = "s" + process.stdout.read().decode()
        process.wait()
        process.stdout.close()
        if said[-1] in "+-":  # else it died halfway, and either is right
            assert Latch(home).is_set is (said[-1] == "+")
        assert not home.exists() or {path.name for path in home.iterdir()} <= {NAME, "halt.new"}
