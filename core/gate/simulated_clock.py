"""The clock of a gate whose robot is simulated: the simulator's own, which waits for a computer that is too slow.

Silence, lateness and ages are judged by it as by any clock. It never runs faster than real time, nor ahead of the
simulator; and the simulator makes no frame later than `until`, or only very slowly: see `core.robots.process`.
A gate before a real robot has the computer's clock and nothing of this.
"""

from core.gate.requests import GateHeartbeat, GateReach, ReachingPart

MAX_AHEAD_S = 0.1  # that the simulator may be ahead of the gate, of each part of the console, and of the heartbeat
MAX_STEP_S = 0.04  # that the clock advances at a tick, at most: two ticks


class SimulatedClock:
    """Counts from the first frame that is reported. Advances at ticks only."""

    def __init__(self, period: float) -> None:
        """`period`: time [s] between two frames of the simulator."""
        self.now = 0.0  # [s]
        self._period = period
        self._first: float | None = None  # [s] robot's clock, of the first frame
        self._frame, self._came = 0.0, 0.0  # [s] newest frame by this clock, and when it came in real time
        self._ticked: float | None = None  # [s] real time
        self._reached: dict[ReachingPart, float] = {}  # [s] robot's clock, of each part that is waited for
        self._beat = 0.0  # [s] of the newest heartbeat

    def report(self, stamp: float, real: float) -> None:
        """Take the stamp of a frame [s], robot's clock, which came at this real time [s]."""
        if self._first is None:
            self._first = stamp - self.now
        self._frame, self._came = stamp - self._first, real

    def hear(self, sign: GateHeartbeat | GateReach) -> None:
        """Note that the console is alive, or how far a part of it has come."""
        if isinstance(sign, GateHeartbeat):
            self._beat = self.now
        elif sign.stamp is None:
            self._reached.pop(sign.part, None)
        else:
            self._reached[sign.part] = sign.stamp

    def advance(self, real: float) -> float:
        """Tick at this real time [s] → the time [s]."""
        passed = 0.0 if self._ticked is None else real - self._ticked
        self._ticked = real
        least = self._frame + min(max(real - self._came, 0.0), self._period)
        self.now += min(max(least - self.now, 0.0), max(passed, 0.0), MAX_STEP_S)
        return self.now

    @property
    def until(self) -> float | None:
        """Time [s] by the robot's clock up to which the simulator may go on; None: no frame has come."""
        if self._first is None:
            return None
        beat = [self._beat + self._first] if "pilot" in self._reached else []
        return min([self.now + self._first, *beat, *self._reached.values()]) + MAX_AHEAD_S
