"""Who runs first on a busy machine: the gate, then what perceives and steers, then everything else."""

from __future__ import annotations

import contextlib
import os

GATE, PILOT = 2, 1


def come_first(rank: int) -> bool:
    """This thread, and whatever it starts from now on, runs before everything of a lower rank → whether that is so.

    It is where the system permits it: Linux, as root or with a limit `rtprio`. Elsewhere nothing changes.
    """
    with contextlib.suppress(OSError, AttributeError):
        os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(rank))
        return True
    return False


def stand_back() -> None:
    """This thread, and whatever it starts from now on, runs like every other program."""
    with contextlib.suppress(OSError, AttributeError):
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
