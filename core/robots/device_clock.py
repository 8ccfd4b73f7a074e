"""A device's own clock, put on the robot's: the quickest of its recent messages tells the difference."""

from __future__ import annotations

from collections import deque

SPAN = 10.0  # [s] over which the quickest message is looked for: a drift of 100 ppm makes 1 ms of it
FELL_BEHIND = 0.15  # [s] by which a message is later than the quickest: it waited on its way …
HELD_UP = 2.0  # [s] … or, when all of them have been so late for so long, the clock was held up
JUMP = 1.0  # [s] backwards by which a clock was reset


class DeviceClock:
    """Minimum filter of receive minus device time: what is late by the link's jitter does not count."""

    def __init__(self, delay: float = 0.0) -> None:
        """`delay` [s]: what even the quickest message takes."""
        self._delay = delay
        self._quickest: deque[tuple[float, float]] = deque()  # received, difference; both rising
        self._last: float | None = None
        self._late_since: float | None = None  # when the first of the late messages was received
        self.offset: float | None = None  # robot's clock minus the device's [s]; None before the first message

    def stamp(self, device: float, received: float) -> float:
        """A device's time [s] of something that was received at `received` [s] → the robot's time of it."""
        if self._last is not None and device < self._last - JUMP:
            self._quickest.clear()
        self._last = device
        difference = received - device
        self._note_late(difference, received)
        while self._quickest and self._quickest[-1][1] >= difference:
            self._quickest.pop()
        self._quickest.append((received, difference))
        while self._late_since is None and self._quickest[0][0] < received - SPAN:
            self._quickest.popleft()
        self.offset = self._quickest[0][1] - self._delay
        return device + self.offset

    def _note_late(self, difference: float, received: float) -> None:
        """Follow a clock that was held up; messages that waited for a frozen reader come late all at once."""
        if not self._quickest or difference - self._quickest[0][1] <= FELL_BEHIND:
            self._late_since = None
        elif self._late_since is None:
            self._late_since = received
        elif received - self._late_since > HELD_UP:
            self._quickest.clear()
            self._late_since = None
