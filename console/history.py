"""What was heard, from whom, and how it ended: the newest at hand, all of it in the store."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any

from console.logins import Person
from console.store import REMEMBERED, Deed, Store
from core.commands.command import Command


class History:
    """Deeds in the order they were done. Lives on the event loop; the store writes behind it."""

    def __init__(self, folder: Path, complain: Callable[[str], None]) -> None:
        self.revision = 0  # of the commands
        self._store = Store(folder / "history.sqlite", time.time(), complain)
        self._deeds: dict[int, Deed] = {}
        self._older: list[Deed] = []
        self._newest = 0

    def open(self) -> None:
        """Remember earlier runs."""
        self._older = self._store.open()
        self._newest = max((deed.id for deed in self._older), default=0)

    def close(self) -> None:
        """Write what is waiting."""
        self._store.close()

    def add(self, what: str, who: Person, *, state: str = "done", **more: Any) -> Deed:
        """Record a deed; its id is new."""
        self._newest += 1
        now = time.time()
        ended = None if state == "running" else now
        deed = Deed(
            self._newest, what, who.name, now, time.monotonic(), role=who.role, state=state, ended=ended, **more
        )
        self._keep(deed)
        return deed

    def end(self, number: int, state: str, remark: str) -> None:
        """A deed ended; ends only once."""
        deed = self._deeds.get(number)
        if deed is not None and deed.state == "running":
            self._keep(replace(deed, state=state, remark=remark, ended=time.time()))

    def find(self, number: int) -> Deed | None:
        """The deed with this id, of this run."""
        return self._deeds.get(number)

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
