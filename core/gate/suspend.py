"""Detection of a suspended machine: in sleep CLOCK_MONOTONIC stands still and CLOCK_BOOTTIME runs on."""

import time
from collections.abc import Callable

MIN_SLEEP_S = 0.1  # of sleep that count
MAX_TRIES = 5


def time_asleep() -> float:
    """Return how long the machine has been suspended since its start [s]; 0 where no clock measures it."""
    boottime = getattr(time, "CLOCK_BOOTTIME", None)
    if boottime is None:
        return 0.0
    asleep = 0.0
    for _ in range(MAX_TRIES):
        before, now, after = time.monotonic(), time.clock_gettime(boottime), time.monotonic()
        asleep = now - 0.5 * (before + after)
        if after - before < 0.1 * MIN_SLEEP_S:  # else this process waited for the processor between the clocks
            break
    return asleep


class SleepWatch:
    """Every deadline by the monotonic clock outlasts a sleep: code that keeps one asks here first."""

    def __init__(self, asleep: Callable[[], float] = time_asleep) -> None:
        self._asleep = asleep
        self._before = asleep()

    def woke(self) -> float:
        """Return the time [s] for which the machine has slept since the last call; 0.0 when it did not."""
        before, self._before = self._before, self._asleep()
        slept = self._before - before
        return slept if slept > MIN_SLEEP_S else 0.0
