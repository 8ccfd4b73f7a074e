"""Who of the console's processes runs before other programs."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import psutil
import pytest

from console.serve import browse
from core.gate.precedence import GATE, PILOT, come_first
from tests.browser.running_console import Running
from tests.core.gate.ranks import apart

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="Only Linux has these priorities.")


def test_the_gate_runs_before_the_pilot_and_both_before_others_where_that_is_permitted(tmp_path: Path) -> None:
    permitted = apart(lambda: come_first(PILOT))
    with Running(tmp_path) as console:
        children = psutil.Process(console.pid).children(recursive=True)
        gates = [one.pid for one in children if "core.gate.process" in one.cmdline()]
        threads = [int(one) for one in os.listdir(f"/proc/{console.pid}/task")]
        ranks = {os.sched_getparam(one).sched_priority for one in threads}
        assert len(gates) == 1 and len(threads) > 3
        assert ranks == ({PILOT} if permitted else {0})
        assert os.sched_getparam(gates[0]).sched_priority == (GATE if permitted else 0)


def test_the_browser_is_opened_like_any_other_program(monkeypatch: pytest.MonkeyPatch) -> None:
    policies: list[int] = []
    monkeypatch.setattr("console.serve.webbrowser.open", lambda _: policies.append(os.sched_getscheduler(0)))

    def opened() -> None:
        come_first(PILOT)
        browse("http://127.0.0.1:8420/")

    apart(opened)
    assert policies == [os.SCHED_OTHER]
