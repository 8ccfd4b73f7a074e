"""The robot's clock and ours: when something of the robot's was, and how much time has passed for the robot since.

A simulated robot's clock waits for a slow computer, so what is late by ours may be fresh by its own.
"""

from __future__ import annotations

import bisect
from collections import deque

CLOCK_MEMORY_S = 30.0  # for which the robot's clock is known in ours


class RobotTime:
    """Lives on the event loop."""

    def __init__(self) -> None:
        self.simulated = False  # ages are counted by the robot's clock
        self._moments: deque[tuple[float, float]] = deque()  # [s] by the robot's clock, and by ours

    def note(self, stamp: float, sensed: float) -> None:
        """A frame of this stamp [s], robot's clock, was sensed then [s], by ours."""
        if self._moments and stamp < self._moments[-1][0]:
            self._moments.clear()  # another clock: the robot was started again
        self._moments.append((stamp, sensed))
        while self._moments[0][0] < stamp - CLOCK_MEMORY_S:
            self._moments.popleft()

    def ours(self, stamp: float) -> float:
        """A moment [s] of the robot's clock → of ours."""
        at, sensed = next((known for known in self._moments if known[0] >= stamp), self._moments[-1])
        return sensed - max(at - stamp, 0.0)

    def elapsed(self, since: float, until: float) -> float:
        """Time [s] that has passed between two moments of our clock, by the robot's where it is simulated."""
        if not self.simulated or not self._moments or since < self._moments[0][1]:
            return until - since
        return min(until - since, self._robots(until) - self._robots(since))

    def _robots(self, moment: float) -> float:
        """A moment [s] of our clock → of the robot's, as of the frame before it."""
        at = bisect.bisect_right(self._moments, moment, key=lambda known: known[1])
        return self._moments[max(at - 1, 0)][0]
