"""What steers runs before other programs, where that is permitted."""

import os
import sys

import pytest

from core.gate.scheduling import CONSOLE_RANK, GATE_RANK, PILOT_RANK, come_first, stand_back
from tests.core.gate.ranks import apart, permitted, rank

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="Only Linux has these priorities.")
where_permitted = pytest.mark.skipif(
    not permitted(), reason="Nothing may run before other programs here: that takes root, or a limit rtprio of 3."
)


@where_permitted
@pytest.mark.parametrize("wanted", [GATE_RANK, PILOT_RANK, CONSOLE_RANK])
def test_it_runs_first_and_tells_so(wanted: int) -> None:
    assert apart(lambda: (come_first(wanted), rank(), os.sched_getscheduler(0))) == (True, wanted, os.SCHED_RR)


@where_permitted
def test_threads_that_it_starts_come_first_too() -> None:
    assert apart(lambda: (come_first(CONSOLE_RANK), apart(rank))) == (True, CONSOLE_RANK)


@where_permitted
def test_who_stands_back_runs_like_every_other_program() -> None:
    def ask() -> tuple[int, int]:
        come_first(PILOT_RANK)
        stand_back()
        return rank(), os.sched_getscheduler(0)

    assert apart(ask) == (0, os.SCHED_OTHER)


def test_the_gate_comes_before_the_pilot_and_that_before_the_rest() -> None:
    assert GATE_RANK > PILOT_RANK > CONSOLE_RANK


@pytest.mark.parametrize("highest", [0, CONSOLE_RANK, PILOT_RANK])
def test_where_not_even_the_gate_may_nothing_comes_first(monkeypatch: pytest.MonkeyPatch, highest: int) -> None:
    given: list[int] = []

    def limited(_: int, policy: int, parameters: os.sched_param) -> None:
        if parameters.sched_priority > highest:
            raise PermissionError
        given.append(parameters.sched_priority)

    monkeypatch.setattr(os, "sched_setscheduler", limited)
    assert not any(come_first(wanted) for wanted in (GATE_RANK, PILOT_RANK, CONSOLE_RANK)) and not given
    stand_back()
    assert given == [0]
