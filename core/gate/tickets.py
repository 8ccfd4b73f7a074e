"""Tickets: numbers that say how old an order is, without any clock but the gate's."""

from __future__ import annotations


class Tickets:
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

    def age(self, ticket: int, now: float) -> float | None:
        """Its age [s]; None when it has expired or was never given out."""
        issued = self._issued.get(ticket)
        return None if issued is None or now - issued > self._lifetime else max(now - issued, 0.0)

    def mark(self, now: float) -> None:
        """Draw a line: tickets given out until now are `before` it, a new one follows at once."""
        self._marked = self.newest
        self.issue(now)

    def is_after_mark(self, ticket: int) -> bool:
        """Whether a ticket was given out after the newest line."""
        return ticket > self._marked
