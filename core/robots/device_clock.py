"""A device's own clock, put on the robot's: the quickest of its messages tells the difference."""

import math

MAX_DRIFT = 500e-6  # by which a computer's clock runs slow against ours, at most; a resonator's: `RESONATOR_DRIFT`
RESONATOR_DRIFT = 5e-3  # of a microcontroller without a crystal
STEP_S = 0.2  # [s] by which the stamps of a source step back, or come before their time, when its clock was set
FELL_BEHIND_S = 0.15  # [s] by which a late message is later than the quickest
LONG_AGO_S = 1e9  # of Unix time (2001), which no clock has reached that counts from its start
HELD_UP_S = 2.0  # [s] for which all messages of all sources were late when the clock was held up
ACTIVE_S = 2.0  # [s] since its last message for which a source has a say in whether it was


class DeviceClock:
    """Minimum filter of receive minus device time: what is late by the link's jitter does not count.

    A source that is late while another is not stays late, however long: what is driven by old readings touches what
    it does not see. By stamps alone, a link that lags as a whole looks like a clock that was held up. Only one of a
    simulator is held up: such a clock `follows` where all sources are late for `HELD_UP_S`, over which nothing is
    driven by them. Any other keeps to the quickest of its messages, however long all others are late; so does one
    that tells the time of day. Of several sources one whose stamps step alone is not believed.
    """

    def __init__(self, drift: float = MAX_DRIFT, *, follows: bool = False) -> None:
        """`drift`: share by which the device's clock may run slow; `follows`: a simulator's, that may be held up."""
        self._drift, self._follows = drift, follows
        self._late: set[str] = set()  # sources whose newest message was late
        self._late_since: float | None = None  # [s] since when those of all sources are
        self._last: dict[str, tuple[float, float]] = {}  # source → its newest stamp, and when that was received [s]
        self._stepped: set[str] = set()  # sources whose stamps stepped and have not come back
        self._received = -math.inf  # [s]
        self.offset: float | None = None  # robot's clock minus the device's [s]; None before the first message

    def stamp(self, device: float, received: float, source: str = "") -> float:
        """A device's time [s] of something that was received at `received` [s] → the robot's time of it.

        `source`: which of the sensors that are stamped by this clock; the stamps of each rise.
        """
        known, self._last[source] = self._last.get(source), (device, received)
        difference = received - device
        if self.offset is None:
            self.offset = difference
        elif known is not None and self._steps(source, device - known[0], difference - self.offset):
            if any(received - at < ACTIVE_S for one, (_, at) in self._last.items() if one not in self._stepped):
                return device + self.offset
            self._last, self.offset = {source: (device, received)}, difference
            self._stepped.clear()
        elif self._is_held_up(source, device, difference - self.offset, received):
            self.offset = difference
        else:
            self.offset = min(difference, self.offset + self._drift * max(received - self._received, 0.0))
        self._received = received
        return device + self.offset

    def _is_held_up(self, source: str, device: float, late: float, received: float) -> bool:
        """Return whether all sources have been late for long; what waited for a frozen reader comes at once."""
        if late <= FELL_BEHIND_S:
            self._late.discard(source)
        else:
            self._late.add(source)
        if not self._follows or device > LONG_AGO_S or not self._late.issuperset(self._last):
            self._late_since = None
        elif self._late_since is None:
            self._late_since = received
        elif received - self._late_since > HELD_UP_S:
            self._late_since = None
            self._late.clear()
            return True
        return False

    def _steps(self, source: str, passed: float, late: float) -> bool:
        """Return whether a source's stamps stepped: by what passed [s] between its last two, or by being early."""
        if passed < -STEP_S or late < -STEP_S:
            self._stepped.add(source)
        elif late <= STEP_S:
            self._stepped.discard(source)
        return source in self._stepped
