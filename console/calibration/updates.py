"""Session updates for the page: the newest only, and not too often."""

from __future__ import annotations

import asyncio
import time

from console import messages
from console.broadcast import Broadcaster
from console.messages.calibration import CalibrationSessionState

STATE_GAP_S = 0.1  # at least between two states of one session, unless it is urgent


class SessionUpdates:
    """Lives on the event loop. Every session is a kind of its own in the broadcaster."""

    def __init__(self, broadcaster: Broadcaster) -> None:
        self._broadcaster = broadcaster
        self._published_at: dict[str, float] = {}
        self._later: dict[str, asyncio.TimerHandle] = {}

    def watched(self, session_id: str) -> bool:
        """Return whether any socket wants this session."""
        return self._broadcaster.watched(topic_of(session_id))

    def changed(self, session: CalibrationSessionState, *, urgent: bool) -> None:
        """Publish at most ten times a second; at once, when it is urgent."""
        if not self.watched(session.id):
            return
        wait = self._published_at.get(session.id, 0.0) + STATE_GAP_S - time.monotonic()
        if urgent or wait <= 0:
            self.publish(session)
        elif session.id not in self._later:
            self._later[session.id] = asyncio.get_running_loop().call_later(wait, self.publish, session)

    def publish(self, session: CalibrationSessionState) -> None:
        """Publish the session as it is."""
        if (waiting := self._later.pop(session.id, None)) is not None:
            waiting.cancel()
        self._published_at[session.id] = time.monotonic()
        self._broadcaster.publish(topic_of(session.id), messages.encode(messages.CalibrationNews(session)).decode())

    def forget(self, session_id: str) -> None:
        """The session was deleted."""
        if (waiting := self._later.pop(session_id, None)) is not None:
            waiting.cancel()
        self._published_at.pop(session_id, None)
        self._broadcaster.forget(topic_of(session_id))


def topic_of(session_id: str) -> str:
    """A session's kind in the broadcaster."""
    return f"calibration:{session_id}"
