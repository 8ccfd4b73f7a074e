"""Nonces: numbers that give the age of a setpoint by the gate's clock alone."""

from __future__ import annotations

from collections.abc import Iterable


class Nonces:
    """Gives out rising numbers and knows for a while when each was given out."""

    def __init__(self, first: int, lifetime: float) -> None:
        self.newest = first
        self._lifetime = lifetime  # [s]
        self._issued: dict[int, float] = {}
        self._marked = first

    def issue(self, now: float) -> None:
        """Give out the next one, and forget those that have expired."""
        self.newest += 1
        self._issued[self.newest] = now
        while now - self._issued[oldest := next(iter(self._issued))] > self._lifetime:
            del self._issued[oldest]

    def age(self, nonce: int, now: float) -> float | None:
        """Its age [s]; None when it has expired or was never given out."""
        issued = self._issued.get(nonce)
        return None if issued is None or now - issued > self._lifetime else max(now - issued, 0.0)

    def mark(self, now: float) -> None:
        """Draw a line: nonces given out until now are `before` it, a new one follows at once."""
        self._marked = self.newest
        self.issue(now)

    def is_after_mark(self, nonce: int) -> bool:
        """Return whether a nonce was given out after the newest mark."""
        return nonce > self._marked


MAX_REMEMBERED_PRESSES = 4096


class InputIds:
    """One present press per source; what was stopped, replaced or overridden never counts again."""

    def __init__(self, over: Iterable[tuple[str, int]] = ()) -> None:
        self._present: dict[str, int] = {}
        self._over: dict[tuple[str, int], None] = dict.fromkeys(over)

    def begin(self, source: str, press: int) -> bool:
        """Make it the present one of its source, whose former one is over → False when it is over itself."""
        if (source, press) in self._over:
            return False
        if self._present.get(source, press) != press:
            self.end(source)
        self._present[source] = press
        return True

    def end(self, source: str) -> None:
        """End the present press of a source."""
        if source in self._present:
            self.refuse(source, self._present[source])

    def end_all(self) -> None:
        """End every present press."""
        for source in self._present:
            self.end(source)

    def refuse(self, source: str, press: int) -> None:
        """Mark this press as over, present or not. The oldest of very many are forgotten."""
        self._over[source, press] = None
        if len(self._over) > MAX_REMEMBERED_PRESSES:
            del self._over[next(iter(self._over))]
