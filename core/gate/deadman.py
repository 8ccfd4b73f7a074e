"""The deadman of a setpoint, the watchdog over the console: when either is silent for too long, the motion ends."""

import math

from core.gate.limits import Limits
from core.gate.status import CONSOLE_SILENT, SILENCE


class Deadman:
    """Judges silence. A setpoint lasts `limits.deadman` [s], and only while the console's heartbeat comes."""

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._beat = self._steady_since = -math.inf

    def heartbeat(self, now: float) -> None:
        """Note that the console is alive."""
        if self.console_silent(now):
            self._steady_since = now
        self._beat = now

    def steady_for(self, now: float) -> float:
        """How long [s] the heartbeat has come without a break."""
        return now - self._steady_since

    def expires(self, arrived: float) -> float:
        """Time [s] at which a setpoint that arrived then ends, unless a new one or a heartbeat comes."""
        return min(arrived + self._limits.deadman, self._beat + self._limits.heartbeat)

    def console_silent(self, now: float) -> bool:
        """Return whether the console's heartbeat is missing; one of the future (a clock was set back) is none."""
        return not abs(now - self._beat) < self._limits.heartbeat

    def trouble(self, arrived: float, now: float) -> str:
        """Return why a setpoint that arrived then must end, "" if it need not."""
        if now >= arrived + self._limits.deadman:
            return SILENCE
        return CONSOLE_SILENT if self.console_silent(now) else ""
