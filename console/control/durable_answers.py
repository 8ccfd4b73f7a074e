"""Answers are sent when their history is on disk: a request that changes something waits for its row.

A stop and a halt wait for nothing.
"""

from console.access.guard import SAFE_METHODS, App, Message, Receive, Scope, Send
from console.control.history import History

URGENT = frozenset({"/api/stop", "/api/halt"})


class DurableAnswers:
    """Holds back the answer to a request that changes something until the history is written."""

    def __init__(self, app: App, *, history: History) -> None:
        self._app = app
        self._history = history

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http" or scope["method"] in SAFE_METHODS or scope["path"] in URGENT:
            await self._app(scope, receive, send)
            return

        async def when_settled(message: Message) -> None:
            if message["type"] == "http.response.start":
                await self._history.settled()
            await send(message)

        await self._app(scope, receive, when_settled)
