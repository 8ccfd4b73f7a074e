"""Newest value wins: many may watch, nobody can make anybody else wait, and no delay can grow."""

from __future__ import annotations

import asyncio
from collections import deque
from dataclasses import dataclass

MAX_ANSWERS = 256  # that may wait for one viewer: a second's worth of asking; past that the viewer does not read


@dataclass(frozen=True)
class CloseSocket:
    code: int
    reason: str


class Subscriber:
    """The messages that one socket still has to be sent."""

    def __init__(self, *kinds: str) -> None:
        self.wants = set(kinds)
        self._turns = list(kinds)
        self.closing: CloseSocket | None = None
        self._answers: deque[str | bytes] = deque()
        self._seen: dict[str, int] = {}
        self._news = asyncio.Event()

    def tell(self, message: str | bytes) -> None:
        """An answer for this viewer alone; these are not skipped."""
        if len(self._answers) >= MAX_ANSWERS:
            self.close(1008, "You ask faster than you read.")
            return
        self._answers.append(message)
        self._news.set()

    def close(self, code: int, reason: str) -> None:
        """Close the socket soon."""
        self.closing = self.closing or CloseSocket(code, reason)
        self._news.set()

    def want(self, kind: str, wanted: bool) -> None:
        """Set whether this viewer wants a kind."""
        (self.wants.add if wanted else self.wants.discard)(kind)
        if wanted and kind not in self._turns:
            self._turns.append(kind)
        self.wake()

    def wake(self) -> None:
        self._news.set()

    async def next(self, broadcaster: Broadcaster) -> str | bytes | None:
        """Wait for the next thing to send: answers first, then the newest of each kind in turn; None: it is over."""
        while self.closing is None:
            if self._answers:
                return self._answers.popleft()
            for kind in self._turns:
                number, value = broadcaster.slots.get(kind, (0, b""))
                if number and kind in self.wants and self._seen.get(kind) != number:
                    self._seen[kind] = number
                    self._turns.remove(kind)
                    self._turns.append(kind)
                    return value
            self._news.clear()
            await self._news.wait()
        return None


class Broadcaster:
    """The newest value of each kind, and its viewers. Lives on the event loop."""

    def __init__(self) -> None:
        self.slots: dict[str, tuple[int, str | bytes]] = {}
        self.viewers: set[Subscriber] = set()
        self._number = 0  # of the newest value of all

    def join(self, viewer: Subscriber) -> None:
        """One more watches. What nobody watched until now may be old: it waits for the next."""
        for kind in viewer.wants:
            self._begin(kind)
        self.viewers.add(viewer)

    def want(self, viewer: Subscriber, kind: str, *, wanted: bool) -> None:
        if wanted:
            self._begin(kind)
        viewer.want(kind, wanted)

    def publish(self, kind: str, value: str | bytes) -> None:
        """Replace the newest value of a kind and wake all who want it."""
        self._number += 1
        self.slots[kind] = (self._number, value)
        for viewer in self.viewers:
            if kind in viewer.wants:
                viewer.wake()

    def forget(self, kind: str) -> None:
        self.slots.pop(kind, None)

    def watched(self, kind: str) -> bool:
        """Return whether any viewer wants this kind; a message that nobody wants need not be made."""
        return any(kind in viewer.wants for viewer in tuple(self.viewers))  # the pilot's thread asks, too

    def _begin(self, kind: str) -> None:
        if not self.watched(kind):
            self.forget(kind)
