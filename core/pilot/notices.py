"""Sentences for the operator, bounded in number."""

from dataclasses import replace

from core.sentences import Statement
from core.snapshot import Level, Notice

SLOW = Statement("pilot.too_slow")
KEEPS_UP = Statement("pilot.keeps_up")
REPEATED_S = 10.0  # [s] within which the same cause goes on: what a driver says again while it lasts is not news


class Notices:
    """The newest notices; a trouble is one notice: it begins, changes in place, and ends as its relief."""

    def __init__(self, most: int = 20) -> None:
        self._most = most
        self._count = 0
        self._troubles: dict[str, str] = {}
        self.newest: tuple[Notice, ...] = ()

    def add(self, stamp: float, level: Level, text: str, cause: str = "") -> None:
        """Add a notice; it replaces an older one of the same cause, or changes one that was said just now."""
        known = [old for old in self.newest if old.cause == cause] if cause else self.newest[-1:]
        same = next((old for old in known if cause or old.text == text), None)
        if same is not None and abs(stamp - same.stamp) < REPEATED_S:
            going_on = replace(same, stamp=stamp, level=level, text=text)
            self.newest = tuple(going_on if old is same else old for old in self.newest)
            return
        self._hang(stamp, level, text, cause)

    def _hang(self, stamp: float, level: Level, text: str, cause: str) -> None:
        self._count += 1
        notice = Notice(id=self._count, stamp=stamp, level=level, text=text, cause=cause)
        kept = tuple(each for each in self.newest if not cause or each.cause != cause)
        self.newest = (*kept, notice)[-self._most :]

    def watch(self, stamp: float, cause: str, trouble: str, level: Level, relief: str) -> None:
        """Show the trouble of one cause in this frame ("" = none); `relief` is shown when it is over."""
        before = self._troubles.get(cause, "")
        self._troubles[cause] = trouble
        if trouble == before:
            return
        notice = Notice(id=0, stamp=stamp, level=level if trouble else "info", text=trouble or relief, cause=cause)
        hangs = before and any(each.cause == cause for each in self.newest)
        if hangs:
            self.newest = tuple(replace(notice, id=each.id) if each.cause == cause else each for each in self.newest)
        else:
            self._hang(stamp, notice.level, notice.text, cause)
