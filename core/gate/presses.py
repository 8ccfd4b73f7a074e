"""Presses: the keys held and the commands given, and which of them are over for good."""

from __future__ import annotations

from collections.abc import Iterable

REMEMBERED = 4096


class Presses:
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
        """The present press of a source is over."""
        if source in self._present:
            self.refuse(source, self._present[source])

    def end_all(self) -> None:
        """Every present press is over."""
        for source in self._present:
            self.end(source)

    def refuse(self, source: str, press: int) -> None:
        """This press is over, present or not. The oldest of very many are forgotten."""
        self._over[source, press] = None
        if len(self._over) > REMEMBERED:
            del self._over[next(iter(self._over))]
