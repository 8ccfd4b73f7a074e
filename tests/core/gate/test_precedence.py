"""What steers runs before other programs, where that is permitted."""

from __future__ import annotations

import os
import sys

import pytest

from core.gate.precedence import GATE, PILOT, come_first, stand_back
from tests.core.gate.ranks import apart

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="Only Linux has these priorities.")


def rank() -> int:
    return os.sched_getparam(0).sched_priority


def test_it_tells_whether_it_runs_first() -> None:
    def ask() -> bool:
        return come_first(PILOT) == (rank() == PILOT)

    assert apart(ask)


def test_who_stands_back_runs_like_every_other_program() -> None:
    def ask() -> tuple[int, int]:
        come_first(PILOT)
        stand_back()
        return rank(), os.sched_getscheduler(0)

    assert apart(ask) == (0, os.SCHED_OTHER)


def test_the_gate_comes_before_the_pilot() -> None:
    assert GATE > PILOT


def test_threads_that_it_starts_come_first_too() -> None:
    def ask() -> bool:
        first = come_first(PILOT)
        return (apart(rank) == PILOT) == first

    assert apart(ask)


def test_where_it_is_forbidden_nothing_changes(monkeypatch: pytest.MonkeyPatch) -> None:
    def forbidden(*_: object) -> None:
        raise PermissionError

    monkeypatch.setattr(os, "sched_setscheduler", forbidden)
    assert not come_first(PILOT)
    stand_back()
