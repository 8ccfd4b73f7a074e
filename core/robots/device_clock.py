"""A device's own clock, put on the robot's: the quickest of its messages tells the difference."""

from __future__ import annotations

import math

MAX_DRIFT = 500e-6  # by which a computer's clock runs slow against ours, at most; a resonator's: `RESONATOR_DRIFT`
RESONATOR_DRIFT = 5e-3  # of a microcontroller without a crystal
SET_BACK_S = 0.2  # [s] by which the stamps of one source step back when its clock was set


class DeviceClock:
    """Minimum filter of receive minus device time: what is late by the link's jitter does not count.

    Messages that are late for longer stay late: by their stamps, a link that lags cannot be told from a clock that
    was held up, and what is driven by old readings touches what it does not see. So the difference grows by no more
    than a clock's drift, until the stamps of a source step back or the device is connected again.
    """

    def __init__(self, drift: float = MAX_DRIFT) -> None:
        """`drift`: share by which the device's clock may run slow."""
        self._drift = drift
        self._last: dict[str, float] = {}  # source → its newest stamp [s]
        self._received = -math.inf  # [s]
        self.offset: float | None = None  # robot's clock minus the device's [s]; None before the first message

    def stamp(self, device: float, received: float, source: str = "") -> float:
        """A device's time [s] of something that was received at `received` [s] → the robot's time of it.

        `source`: which of the sensors that are stamped by this clock; the stamps of each rise.
        """
        if device < self._last.get(source, device) - SET_BACK_S:
            self._last.clear()
            self.offset = None
        self._last[source] = device
        difference = received - device
        if self.offset is not None:
            difference = min(difference, self.offset + self._drift * max(received - self._received, 0.0))
        self.offset, self._received = difference, received
        return device + difference
