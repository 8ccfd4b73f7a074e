"""Who of the console's processes runs before other programs."""

import contextlib
import os
import sys
from collections import Counter
from pathlib import Path

import psutil
import pytest

from console.access.browser import browse
from core.gate.scheduling import CONSOLE_RANK, GATE_RANK, PILOT_RANK, come_first
from tests.browser.running_console import Running, write_log
from tests.core.gate.ranks import apart, permitted

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="Only Linux has these priorities.")


def ranks_of(process: int) -> Counter[int]:
    """How many of its threads have which rank."""
    ranks: Counter[int] = Counter()
    for thread in os.listdir(f"/proc/{process}/task"):
        with contextlib.suppress(ProcessLookupError):  # it ended meanwhile
            ranks[os.sched_getparam(int(thread)).sched_priority] += 1
    return ranks


def test_the_gate_runs_before_the_pilot_and_both_before_others_where_that_is_permitted(tmp_path: Path) -> None:
    with Running(tmp_path) as console:
        children = psutil.Process(console.pid).children(recursive=True)
        ours = {
            name: [os.sched_getparam(one.pid).sched_priority for one in children if module in one.cmdline()]
            for name, module in (("gate", "core.gate.process"), ("driver", "core.robots.process"))
        }
        threads = ranks_of(console.pid)
    if permitted():
        assert ours == {"gate": [GATE_RANK], "driver": [CONSOLE_RANK]}
        assert 0 < threads[PILOT_RANK] < threads[CONSOLE_RANK] and set(threads) == {PILOT_RANK, CONSOLE_RANK}
    else:
        assert ours == {"gate": [0], "driver": [0]} and set(threads) == {0}


@pytest.mark.campaign
def test_the_simulator_comes_before_nobody_unless_it_is_asked_to(tmp_path: Path) -> None:
    with Running(tmp_path, precedence=False) as console:
        processes = [console.pid, *(one.pid for one in psutil.Process(console.pid).children(recursive=True))]
        assert {os.sched_getscheduler(one) for one in processes} == {os.SCHED_OTHER}


@pytest.mark.campaign
def test_who_only_plays_a_recording_back_comes_before_nobody(tmp_path: Path) -> None:
    with Running(tmp_path, "--robot", f"log:{write_log(tmp_path / 'corridor.log')}") as console:
        children = psutil.Process(console.pid).children(recursive=True)
        (driver,) = [one.pid for one in children if "core.robots.process" in one.cmdline()]
        assert os.sched_getscheduler(driver) == os.SCHED_OTHER


def test_the_browser_is_opened_like_any_other_program(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    policies: list[int] = []
    monkeypatch.setattr("console.access.browser.webbrowser.open", lambda _: policies.append(os.sched_getscheduler(0)))

    def opened() -> None:
        come_first(CONSOLE_RANK)
        browse("http://127.0.0.1:8420/", tmp_path, 0.0)

    apart(opened)
    assert policies == [os.SCHED_OTHER]
