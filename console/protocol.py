"""How long a silent or stuck peer may hold a connection: uvicorn itself sets no bound to either."""

from __future__ import annotations

import socket
from asyncio import BaseTransport, Task, TimerHandle
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.protocol import State

HEADER_TIME = 10.0  # [s] for the whole head of a request
REST_TIME = 2.0  # [s] to finish sending a body that was answered already
PARTING = 1.0  # [s] for the last bytes of a socket that is over
UNSENT = 65536  # [bytes] that may wait in the kernel for one viewer: beyond, newer pictures replace older ones


class ImpatientHttp(H11Protocol):
    """Drops a connection whose request head does not come, or whose answered body does not end."""

    _deadline: TimerHandle | None = None
    _due = ""  # what the deadline is for: "head" | "rest" | ""

    def connection_made(self, transport: BaseTransport) -> None:  # type: ignore[override]
        """A head is due."""
        super().connection_made(transport)  # type: ignore[arg-type]
        self._expect("head", HEADER_TIME)

    def data_received(self, data: bytes) -> None:
        """Something came: a head, a part of one, a body."""
        super().data_received(data)
        if self.transport.is_closing():
            self._calm()
        elif self.conn.their_state is h11.IDLE:
            self._expect("head", HEADER_TIME)
        elif self._due == "head" or self.conn.their_state is not h11.SEND_BODY:
            self._calm()

    def on_response_complete(self) -> None:
        """Answered; the peer may still be sending."""
        super().on_response_complete()
        if self.conn.their_state is h11.SEND_BODY and not self.transport.is_closing():
            self._expect("rest", REST_TIME)

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        """From now on another protocol listens."""
        self._calm()
        super().handle_websocket_upgrade(event)

    def connection_lost(self, exc: Exception | None) -> None:
        """It is over."""
        self._calm()
        super().connection_lost(exc)

    def _expect(self, what: str, within: float) -> None:
        """A deadline that runs is not put off by what trickles in."""
        if self._due != what:
            self._calm()
            self._due, self._deadline = what, self.loop.call_later(within, self.transport.abort)

    def _calm(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
        self._due, self._deadline = "", None


class ImpatientSocket(WebSocketsSansIOProtocol):
    """Lets little wait in the kernel, and goes when it is over, whether or not the peer reads."""

    def connection_made(self, transport: BaseTransport) -> None:
        """Bound what the kernel keeps for a peer that reads slowly."""
        super().connection_made(transport)
        raw: Any = transport.get_extra_info("socket")
        option = getattr(socket, "TCP_NOTSENT_LOWAT", None)
        if raw is not None and option is not None and raw.family in (socket.AF_INET, socket.AF_INET6):
            raw.setsockopt(socket.IPPROTO_TCP, option, UNSENT)

    def on_task_complete(self, task: Task[None]) -> None:
        """The conversation is over; the last bytes get a moment."""
        super().on_task_complete(task)
        self.loop.call_later(PARTING, self.transport.abort)

    def keepalive_timeout(self) -> None:
        """No pong came: the peer is gone, and so is whatever still waited for it."""
        super().keepalive_timeout()
        self.loop.call_later(PARTING, self.transport.abort)

    def shutdown(self) -> None:
        """The console ends; uvicorn's own way raises where the peer has just said good-bye."""
        if self.handshake_complete and self.conn.state is not State.OPEN:
            self.stop_keepalive()
            self.transport.close()
        else:
            super().shutdown()
        self.loop.call_later(PARTING / 4, self.transport.abort)
