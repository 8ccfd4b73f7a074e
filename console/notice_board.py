"""Sentences for the operator, the pilot's and the console's own, in one list."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import replace

from core.snapshot import Level, Notice

SHOWN = 20


class NoticeBoard:
    """The newest notices, newest last."""

    def __init__(self) -> None:
        self.shown: deque[Notice] = deque(maxlen=SHOWN)
        self._newest = 0
        self._adopted = 0  # the pilot's own number of its newest notice that hangs here
        self._stamp = 0.0

    def tell(self, level: Level, text: str) -> None:
        """Hang a notice; what hangs there as the newest already is not repeated."""
        if self.shown and self.shown[-1].text == text:
            return
        self._hang(Notice(id=0, stamp=self._stamp, level=level, text=text))

    def adopt(self, notices: Iterable[Notice], stamp: float) -> None:
        """Hang what is new of the pilot's notices; `stamp` is the robot's clock."""
        self._stamp = stamp
        for notice in notices:
            if notice.id > self._adopted:
                self._adopted = notice.id
                self._hang(notice)

    def another_pilot(self) -> None:
        """A new pilot counts its notices from the beginning."""
        self._adopted = 0

    def _hang(self, notice: Notice) -> None:
        self._newest += 1
        self.shown.append(replace(notice, id=self._newest))
