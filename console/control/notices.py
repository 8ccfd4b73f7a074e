"""Sentences for the operator, the pilot's and the console's own, in one list."""

import time
from collections.abc import Callable, Iterable
from dataclasses import replace

from core.snapshot import Level, Notice

MAX_SHOWN = 20


class Notifications:
    """The newest notices, newest last: one of a cause, and no sentence twice."""

    def __init__(self, clock: Callable[[], float] = time.time) -> None:
        """`clock`: Unix time [s]."""
        self._clock = clock
        self.shown: tuple[Notice, ...] = ()
        self._newest = 0
        self._adopted: dict[int, int] = {}  # the pilot's own numbers of its notices → those here
        self._stamp = 0.0

    def tell(self, level: Level, text: str, cause: str = "") -> None:
        """Hang a notice; what hangs there as the newest already, of the same cause, is not repeated."""
        if self.shown and (self.shown[-1].text, self.shown[-1].cause) == (text, cause):
            return
        self._hang(Notice(id=0, stamp=self._stamp, level=level, text=text, cause=cause))

    def adopt(self, notices: Iterable[Notice], stamp: float) -> None:
        """Show the pilot's new notices, and update changed ones; `stamp` is the robot's clock."""
        self._stamp = stamp
        newest = max(self._adopted, default=0)
        for notice in notices:
            if notice.id > newest:
                self._adopted[notice.id] = self._hang(notice)
            elif (number := self._adopted.get(notice.id)) is not None:
                self._change(number, notice)

    def reset_pilot(self) -> None:
        """A new pilot counts its notices from the beginning, and finds faults by itself."""
        old = set(self._adopted.values())
        self.shown = tuple(notice for notice in self.shown if not notice.cause or notice.id not in old)
        self._adopted.clear()

    def _hang(self, notice: Notice) -> int:
        self._newest += 1
        others = [old for old in self.shown if old.text != notice.text]
        kept = [old for old in others if not notice.cause or old.cause != notice.cause]
        self.shown = (*kept, replace(notice, id=self._newest, at=self._clock()))[-MAX_SHOWN:]
        self._adopted = dict([*self._adopted.items()][-MAX_SHOWN:])
        return self._newest

    def _change(self, number: int, notice: Notice) -> None:
        before = next((old for old in self.shown if old.id == number), None)
        fresh = replace(notice, id=number, at=0.0 if before is None else before.at)
        if before is None or vars(fresh) == vars(before):
            return
        fresh = replace(fresh, at=self._clock())
        self.shown = tuple(fresh if old is before else old for old in self.shown)
