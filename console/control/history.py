"""The history: commands, by whom, and how they ended; the newest at hand, all of it in the store.

Nobody fills it: what a viewer does, and what an operator is refused, is written down one by one within an allowance;
what is more is one row that counts.
"""

import asyncio
import contextlib
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import TypedDict, Unpack

from console.access.logins import Person
from console.control.history_store import MAX_REMEMBERED_ENTRIES, HistoryEntry, HistoryStore
from core.commands.command import Command

REFUSED_ALLOWANCE = (60, 30.0)  # refused commands of an operator: at once, and a minute
VIEWER_ALLOWANCE = (20, 2.0)  # all events of a viewer
VIEWERS_ALLOWANCE = (60, 6.0)  # all events of all viewers together
MAX_PEOPLE = 1000  # whose rows are counted
COUNTED_ROW_S = 600.0  # after which another row counts
MOST_BEYOND = 64  # entries without a row that are known while they last
DISK_TIMEOUT_S = 5.0  # that an answer waits for the disk


class CommandFields(TypedDict, total=False):
    source: str
    words: str  # as they arrived
    heard_as: str  # as they were understood
    name: str
    numbers: dict[str, float]


class EntryFields(CommandFields, total=False):
    """The fields of an entry that not every event has."""

    remark: str


@dataclass
class CountedEntry:
    """The row that stands for many of one person."""

    entry: HistoryEntry
    number: int = 0


class EntryAllowance:
    """Entries of one person: a bucket that holds `most`, and gains `a_minute` of them every minute."""

    def __init__(self, most: int, a_minute: float) -> None:
        self._most, self._rate = most, a_minute / 60.0
        self._left, self._at = float(most), float("-inf")

    def take(self, now: float) -> bool:
        """One of them at `now` [s] → whether there was one."""
        if self._at > float("-inf"):
            self._left = min(self._most, self._left + self._rate * (now - self._at))
        self._at = now
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True


class History:
    """Entries in the order of their events. Lives on the event loop; the store writes behind it."""

    def __init__(self, folder: Path, complain: Callable[[str], None]) -> None:
        self.revision = 0  # of the commands
        self._store = HistoryStore(folder / "history.sqlite", time.time(), complain)
        self._entries: dict[int, HistoryEntry] = {}
        self._beyond: dict[int, HistoryEntry] = {}  # newest entries that are only counted in another row
        self._counted: dict[str, CountedEntry] = {}  # by person
        self._allowances: dict[str, EntryAllowance] = {}  # by person, and of all viewers together
        self._older: list[HistoryEntry] = []
        self._newest = 0

    def open(self) -> None:
        self._older = self._store.open()
        self._newest = max((entry.id for entry in self._older), default=0)

    def close(self) -> None:
        for counted in self._counted.values():
            self._store.keep(counted.entry)
        self._store.close()

    async def settled(self) -> None:
        """Wait until all that was added is on disk; not for long, and not for a disk that refuses."""
        settling = self._store.settled()
        if settling is not None:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(DISK_TIMEOUT_S):
                    await asyncio.wrap_future(settling)

    def add(self, what: str, who: Person, *, state: str = "done", **more: Unpack[EntryFields]) -> HistoryEntry:
        """Record an entry; its id is new."""
        self._newest += 1
        now = time.time()
        ended = None if state == "running" else now
        entry = HistoryEntry(
            self._newest, what, who.name, now, time.monotonic(), role=who.role, state=state, ended=ended, **more
        )
        if self._allowed(entry, who):
            self._keep(entry)
        else:
            self._count(entry, who)
        return entry

    def _allowed(self, entry: HistoryEntry, who: Person) -> bool:
        if who.may("operator"):
            return entry.state != "refused" or self._allowance(who.id, *REFUSED_ALLOWANCE).take(entry.mono)
        own = self._allowance(who.id, *VIEWER_ALLOWANCE).take(entry.mono)
        return own and self._allowance("all viewers", *VIEWERS_ALLOWANCE).take(entry.mono)

    def _allowance(self, whose: str, most: int, a_minute: float) -> EntryAllowance:
        if len(self._allowances) >= MAX_PEOPLE:
            self._allowances.clear()
        return self._allowances.setdefault(whose, EntryAllowance(most, a_minute))

    def _count(self, entry: HistoryEntry, who: Person) -> None:
        """One more of which the person's newest row only tells how many."""
        self._beyond[entry.id] = entry
        if len(self._beyond) > MOST_BEYOND:
            del self._beyond[next(iter(self._beyond))]
        if len(self._counted) >= MAX_PEOPLE:
            self._counted.clear()
        counted = self._counted.get(who.id)
        if counted is None or entry.mono - counted.entry.mono > COUNTED_ROW_S:
            self._counted[who.id] = counted = CountedEntry(replace(entry, state="refused", ended=entry.wall))
        counted.number += 1
        remark = f"And {counted.number} more by the same person, too many to be written down one by one."
        counted.entry = replace(counted.entry, remark=remark, ended=entry.wall)
        if counted.number & (counted.number - 1) == 0:
            self._keep(counted.entry)  # on disk at 1, 2, 4, 8, …, and in the end
        elif counted.entry.id in self._entries:
            self._entries[counted.entry.id] = counted.entry

    def end(self, number: int, state: str, remark: str) -> None:
        """End an entry; it ends only once."""
        entry = self._entries.get(number)
        if number in self._beyond:
            self._beyond[number] = replace(self._beyond[number], state=state, remark=remark, ended=time.time())
        elif entry is not None and entry.state == "running":
            self._keep(replace(entry, state=state, remark=remark, ended=time.time()))

    def find(self, number: int) -> HistoryEntry | None:
        """The entry with this id, of this run."""
        return self._beyond.get(number) or self._entries.get(number)

    def newest_first(self, *, commands_only: bool, limit: int = MAX_REMEMBERED_ENTRIES) -> list[HistoryEntry]:
        """The newest `limit` of the entries in memory."""
        entries = [*self._older, *self._entries.values()][-MAX_REMEMBERED_ENTRIES:]
        wanted = (entry for entry in reversed(entries) if entry.what == "command" or not commands_only)
        return list(islice(wanted, limit))

    def _keep(self, entry: HistoryEntry) -> None:
        self._entries[entry.id] = entry
        if len(self._entries) > MAX_REMEMBERED_ENTRIES:
            del self._entries[
                next(old.id for old in self._entries.values() if old.state != "running" or old is entry)
            ]
        self.revision += entry.what == "command"
        self._store.keep(entry)


def row_of(heard: Command, words: str, source: str) -> CommandFields:
    numbers = dict(heard.numbers)
    return CommandFields(source=source, words=words, heard_as=heard.heard_as, name=heard.name, numbers=numbers)
