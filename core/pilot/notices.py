"""Sentences for the operator, bounded in number."""

from __future__ import annotations

from core.snapshot import Level, Notice


class Notices:
    """The newest notices; a trouble is told once when it begins and once when it ends."""

    def __init__(self, most: int = 20) -> None:
        self._most = most
        self._count = 0
        self._troubles: dict[str, str] = {}
        self.newest: tuple[Notice, ...] = ()

    def add(self, stamp: float, level: Level, text: str) -> None:
        """Tell something once."""
        self._count += 1
        notice = Notice(id=self._count, stamp=stamp, level=level, text=text)
        self.newest = (*self.newest, notice)[-self._most :]

    def watch(self, stamp: float, source: str, trouble: str, level: Level, relief: str = "") -> None:
        """What is wrong with a source in this frame ("" = nothing): told when it begins; `relief` when it is over."""
        before = self._troubles.get(source, "")
        self._troubles[source] = trouble
        if trouble and trouble != before:
            self.add(stamp, level, trouble)
        elif before and not trouble and relief:
            self.add(stamp, "info", relief)
