"""Trying what runs before what without changing the rank of the tests themselves."""

import contextlib
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

from core.gate.scheduling import GATE_RANK


def apart(do: Callable[[], object]) -> object:
    """What it says in a thread of its own, whose rank ends with it."""
    with ThreadPoolExecutor(1) as one:
        return one.submit(do).result()


def rank() -> int:
    """This thread's; 0: none, like every other program's."""
    return os.sched_getparam(0).sched_priority


def permitted() -> bool:
    """Whether the system lets anything of ours run first."""

    def ask() -> bool:
        with contextlib.suppress(OSError, AttributeError):
            os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(GATE_RANK))
            return True
        return False

    return bool(apart(ask))
