"""Scheduling on a busy machine: first the gate, then the pilot, then what both wait for, then everything else."""

import contextlib
import os

GATE_RANK, PILOT_RANK, CONSOLE_RANK = 3, 2, 1  # the console: its other threads, and the driver


def come_first(rank: int) -> bool:
    """Run this thread, and all that it starts from now on, before everything of a lower rank → whether that is so.

    It is where the system permits all ranks: Linux, as root or with a limit `rtprio` of 3. Elsewhere nothing changes:
    a pilot that came before its gate would be worse than none that comes first.
    """
    with contextlib.suppress(OSError, AttributeError):
        for each in (GATE_RANK, rank):
            os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(each))
        return True
    return False


def stay_first(rank: int) -> bool:
    """The same where what started this thread comes first already; elsewhere nothing changes."""
    with contextlib.suppress(OSError, AttributeError):
        return os.sched_getscheduler(0) == os.SCHED_RR and come_first(rank)
    return False


def stand_back() -> None:
    """Run this thread, and all that it starts from now on, like every other program."""
    with contextlib.suppress(OSError, AttributeError):
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
