"""Telling the page how sessions change: the newest only, and not too often."""

from __future__ import annotations

import asyncio
import time

from console import wire
from console.latest import Hub
from console.wire_calibration import CalibrationSession

GAP = 0.1  # [s] at least between two states of one session, unless it is urgent


class News:
    """Lives on the event loop. Every session is a kind of its own in the hub."""

    def __init__(self, hub: Hub) -> None:
        self._hub = hub
        self._told_at: dict[str, float] = {}
        self._later: dict[str, asyncio.TimerHandle] = {}

    def watched(self, session_id: str) -> bool:
        """Whether any socket wants this session."""
        return self._hub.watched(kind_of(session_id))

    def changed(self, session: CalibrationSession, *, urgent: bool) -> None:
        """Publish at most ten times a second; at once, when it is urgent."""
        if not self.watched(session.id):
            return
        wait = self._told_at.get(session.id, 0.0) + GAP - time.monotonic()
        if urgent or wait <= 0:
            self.publish(session)
        elif session.id not in self._later:
            self._later[session.id] = asyncio.get_running_loop().call_later(wait, self.publish, session)

    def publish(self, session: CalibrationSession) -> None:
        """Tell it as it is."""
        if (waiting := self._later.pop(session.id, None)) is not None:
            waiting.cancel()
        self._told_at[session.id] = time.monotonic()
        self._hub.publish(kind_of(session.id), wire.encode(wire.CalibrationNews(session)).decode())

    def forget(self, session_id: str) -> None:
        """The session was deleted."""
        if (waiting := self._later.pop(session_id, None)) is not None:
            waiting.cancel()
        self._told_at.pop(session_id, None)
        self._hub.forget(kind_of(session_id))


def kind_of(session_id: str) -> str:
    """A session's kind in the hub."""
    return f"calibration:{session_id}"
