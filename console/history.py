"""What was heard, from whom, and how it ended: the newest at hand, all of it in the store.

Nobody fills it: what a viewer does, and what an operator is refused, is written down one by one within an allowance;
what is more is one row that counts.
"""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Any

from console.allowance import Allowance
from console.logins import Person
from console.store import REMEMBERED, Deed, Store
from core.commands.command import Command

REFUSED = (60, 30.0)  # refused commands of an operator: at once, and a minute
VIEWER = (20, 2.0)  # whatever a viewer does
VIEWERS = (60, 6.0)  # whatever all viewers together do
PEOPLE = 1000  # whose rows are counted
COUNTED = 600.0  # [s] after which another row counts
MOST_BEYOND = 64  # deeds without a row that are known while they last
PATIENCE = 5.0  # [s] that an answer waits for the disk


@dataclass
class Counted:
    """The row that stands for many of one person."""

    deed: Deed
    number: int = 0


class History:
    """Deeds in the order they were done. Lives on the event loop; the store writes behind it."""

    def __init__(self, folder: Path, complain: Callable[[str], None]) -> None:
        self.revision = 0  # of the commands
        self._store = Store(folder / "history.sqlite", time.time(), complain)
        self._deeds: dict[int, Deed] = {}
        self._beyond: dict[int, Deed] = {}  # newest deeds that only a row that counts tells of
        self._counted: dict[str, Counted] = {}  # by person
        self._allowances: dict[str, Allowance] = {}  # by person, and of all viewers together
        self._older: list[Deed] = []
        self._newest = 0

    def open(self) -> None:
        """Remember earlier runs."""
        self._older = self._store.open()
        self._newest = max((deed.id for deed in self._older), default=0)

    def close(self) -> None:
        """Write what is waiting."""
        for counted in self._counted.values():
            self._store.keep(counted.deed)
        self._store.close()

    async def settled(self) -> None:
        """Wait until all that was added is on disk; not for long, and not for a disk that refuses."""
        settling = self._store.settled()
        if settling is not None:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(PATIENCE):
                    await asyncio.wrap_future(settling)

    def add(self, what: str, who: Person, *, state: str = "done", **more: Any) -> Deed:
        """Record a deed; its id is new."""
        self._newest += 1
        now = time.time()
        ended = None if state == "running" else now
        deed = Deed(
            self._newest, what, who.name, now, time.monotonic(), role=who.role, state=state, ended=ended, **more
        )
        if self._allowed(deed, who):
            self._keep(deed)
        else:
            self._count(deed, who)
        return deed

    def _allowed(self, deed: Deed, who: Person) -> bool:
        """Whether this deed has a row of its own."""
        if who.may("operator"):
            return deed.state != "refused" or self._allowance(who.id, *REFUSED).take(deed.mono)
        own = self._allowance(who.id, *VIEWER).take(deed.mono)
        return own and self._allowance("all viewers", *VIEWERS).take(deed.mono)

    def _allowance(self, whose: str, most: int, a_minute: float) -> Allowance:
        if len(self._allowances) >= PEOPLE:
            self._allowances.clear()
        return self._allowances.setdefault(whose, Allowance(most, a_minute))

    def _count(self, deed: Deed, who: Person) -> None:
        """One more of which the person's newest row only tells how many."""
        self._beyond[deed.id] = deed
        if len(self._beyond) > MOST_BEYOND:
            del self._beyond[next(iter(self._beyond))]
        if len(self._counted) >= PEOPLE:
            self._counted.clear()
        counted = self._counted.get(who.id)
        if counted is None or deed.mono - counted.deed.mono > COUNTED:
            self._counted[who.id] = counted = Counted(replace(deed, state="refused", ended=deed.wall))
        counted.number += 1
        remark = f"And {counted.number} more by the same person, too many to be written down one by one."
        counted.deed = replace(counted.deed, remark=remark, ended=deed.wall)
        if counted.number & (counted.number - 1) == 0:
            self._keep(counted.deed)  # on disk at 1, 2, 4, 8, …, and in the end
        elif counted.deed.id in self._deeds:
            self._deeds[counted.deed.id] = counted.deed

    def end(self, number: int, state: str, remark: str) -> None:
        """A deed ended; ends only once."""
        deed = self._deeds.get(number)
        if number in self._beyond:
            self._beyond[number] = replace(self._beyond[number], state=state, remark=remark, ended=time.time())
        elif deed is not None and deed.state == "running":
            self._keep(replace(deed, state=state, remark=remark, ended=time.time()))

    def find(self, number: int) -> Deed | None:
        """The deed with this id, of this run."""
        return self._beyond.get(number) or self._deeds.get(number)

    def newest_first(self, *, commands_only: bool, limit: int = REMEMBERED) -> list[Deed]:
        """The newest `limit` of what is remembered."""
        deeds = [*self._older, *self._deeds.values()][-REMEMBERED:]
        wanted = (deed for deed in reversed(deeds) if deed.what == "command" or not commands_only)
        return list(islice(wanted, limit))

    def _keep(self, deed: Deed) -> None:
        self._deeds[deed.id] = deed
        if len(self._deeds) > REMEMBERED:
            del self._deeds[next(old.id for old in self._deeds.values() if old.state != "running" or old is deed)]
        self.revision += deed.what == "command"
        self._store.keep(deed)


def row_of(heard: Command, words: str, source: str) -> dict[str, Any]:
    """What the history says of an order beside who gave it and how it went."""
    numbers = dict(heard.numbers)
    return {"source": source, "words": words, "heard_as": heard.heard_as, "name": heard.name, "numbers": numbers}
