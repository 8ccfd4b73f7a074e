"""Talk that is no command: it stands in the history once, until something else does, however long it goes on."""

from __future__ import annotations

from typing import Any

from console.history import History
from console.logins import Person
from console.store import Deed


class Prattle:
    """What one listener hears and nobody understands. Lives on the event loop."""

    def __init__(self, history: History) -> None:
        self._history = history
        self._told = 0  # in the history

    def tell(self, who: Person, **more: Any) -> Deed | None:
        """Into the history, unless it is the newest there already."""
        newest = self._history.newest_first(commands_only=True, limit=1)
        if newest and newest[0].id == self._told:
            return None
        deed = self._history.add("command", who, state="refused", words="", **more)
        self._told = deed.id
        return deed
