"""Retry and backoff: when a process that died is started again, and when it is not."""

from __future__ import annotations

import math
from collections import deque

MAX_CRASHES, CRASH_WINDOW_S = 3, 60.0  # that many within so many seconds are the last
RESTART_PAUSE_S = 0.5  # more before each further start
RETRY_S = 2.0  # after a start for which the system had no means


class Restarts:
    """Counts deaths; `due` when the next start is."""

    def __init__(self) -> None:
        self._deaths: deque[float] = deque(maxlen=MAX_CRASHES)
        self._again_at = 0.0  # [s]

    def due(self, now: float) -> bool:
        """True if the missing process is started again now."""
        return now >= self._again_at

    def died(self, now: float) -> str:
        """Another death at `now` [s] → the consequence, a sentence."""
        self._deaths.append(now)
        if len(self._deaths) == MAX_CRASHES and now - self._deaths[0] < CRASH_WINDOW_S:
            self._again_at = math.inf
            return "That was the third time within a minute, so it stays off: restart the console."
        self._again_at = now + RESTART_PAUSE_S * (len(self._deaths) - 1)
        return "It is started again."

    def forgive(self, now: float) -> str:
        """Handle a process that ended through no fault of its own → the consequence, a sentence."""
        self._again_at = now
        return "It is started again."

    def postpone(self, now: float) -> str:
        """The start failed for want of memory, descriptors or processes → the consequence, a sentence."""
        self._again_at = now + RETRY_S
        return f"It is tried again every {RETRY_S:g} seconds."
