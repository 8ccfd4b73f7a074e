"""How many within the present second."""

from __future__ import annotations


class Tally:
    """Counts within whole seconds that begin with the first of each."""

    def __init__(self) -> None:
        self._second = float("-inf")  # [s] when the present one began
        self._count = 0

    def add(self, now: float) -> int:
        """One more at `now` [s] → how many of this second there are with it."""
        if now - self._second >= 1.0:
            self._second, self._count = now, 0
        self._count += 1
        return self._count
