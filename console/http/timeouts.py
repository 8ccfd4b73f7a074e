"""Limits of one connection: time while it is silent or stuck, a share of the event loop, a place.

uvicorn itself sets no bound to any of them.
"""

import socket
import time
from asyncio import BaseTransport, Task, TimerHandle
from collections.abc import Callable
from typing import Any

import h11
import uvicorn
from uvicorn.protocols.http.flow_control import FlowControl
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.protocol import State

from console.http.connection_limits import ConnectionLimits
from console.http.incremental_parsing import PIECE_BYTES, IncrementalProtocol
from console.http.rate_counter import RateCounter

HEADER_TIME_S = 10.0  # for the whole head of a request
REST_TIME_S = 2.0  # to finish sending a body that was answered already
PARTING_S = 1.0  # for the last bytes of a socket that is over
SHORT_BODY_BYTES = 65536  # of a body that is read to its end though it was answered already
MOST_PINGS = 20  # a second on one socket; browsers send none, programs one in some seconds
PLAIN_PIECE_BYTES = 4096  # of a body parsed at once: what follows it in the same piece may be costly
MAX_UNSENT_BYTES = 65536  # that may wait in the kernel for one viewer: beyond, newer pictures replace older ones


class ServerConfig(uvicorn.Config):
    """uvicorn's, and who is there."""

    crowd: ConnectionLimits


class ResumingFlowControl(FlowControl):
    """Tells when reading may go on."""

    def __init__(self, transport: Any, resumed: Callable[[], None]) -> None:
        super().__init__(transport)
        self._resumed = resumed

    def resume_reading(self) -> None:
        if self.read_paused:
            super().resume_reading()
            self._resumed()

    def end(self) -> None:
        """The connection is over, and its protocol is held no more."""
        self._resumed = lambda: None


class TimeoutHttp(IncrementalProtocol, H11Protocol):
    """Drops a connection whose request head does not come, or whose answered body does not end."""

    def __init__(self, config: ServerConfig, *given: Any, **more: Any) -> None:
        IncrementalProtocol.__init__(self, config.crowd.parsing)
        H11Protocol.__init__(self, config, *given, **more)
        self._crowd = config.crowd
        self._deadline: TimerHandle | None = None
        self._due = ""  # what the deadline is for: "head" | "rest" | ""

    def connection_made(self, transport: BaseTransport) -> None:  # type: ignore[override]
        """A head is due."""
        H11Protocol.connection_made(self, transport)  # type: ignore[arg-type]
        self.flow = ResumingFlowControl(self.transport, self.go_on_soon)
        send_at_once(transport)
        self._expect("head", HEADER_TIME_S)
        self._crowd.enter(self, address_of(self.client))

    @property
    def stranger(self) -> bool:
        scope: Any = self.scope  # None before the first request
        return scope is None or scope.get("person") is None

    @property
    def idle(self) -> bool:
        cycle: Any = self.cycle  # None before the first request
        return cycle is None or cycle.response_complete

    def data_received(self, data: bytes) -> None:
        """Something came. The rest of a long body that was answered is not even parsed: it ends the connection."""
        if self._due != "rest" or self._short:
            self.arrived(data)

    @property
    def full(self) -> bool:
        return self.flow.read_paused

    @property
    def piece(self) -> int:
        """More of a body of known length: it has no structure that takes time."""
        plain = self.conn.their_state is h11.SEND_BODY and self._length is not None
        return PLAIN_PIECE_BYTES if plain else PIECE_BYTES

    @property
    def _length(self) -> int | None:
        """The length of the body [bytes] by the head; None: it comes in chunks."""
        headers = dict(self.headers or ())
        return None if b"transfer-encoding" in headers else int(headers.get(b"content-length", 0))

    @property
    def _short(self) -> bool:
        """Return whether the rest of the body is worth reading for the next request on this connection."""
        return self._length is not None and self._length <= SHORT_BODY_BYTES

    @property
    def replaced(self) -> bool:
        return self.transport.get_protocol() is not self  # type: ignore[comparison-overlap]

    def take(self, piece: bytes) -> None:
        H11Protocol.data_received(self, piece)
        if self.transport.is_closing():
            self._cancel_deadline()
        elif self.conn.their_state is h11.IDLE:
            self._expect("head", HEADER_TIME_S)
        elif self._due == "head" or self.conn.their_state is not h11.SEND_BODY:
            self._cancel_deadline()

    def on_response_complete(self) -> None:
        """Answered; the peer may still be sending."""
        super().on_response_complete()
        if self.conn.their_state is h11.SEND_BODY and not self.transport.is_closing():
            self._expect("rest", REST_TIME_S)
            if not self._short:
                self.forget()
                self.transport.resume_reading()

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        self._cancel_deadline()
        self._crowd.leave(self, address_of(self.client))
        super().handle_websocket_upgrade(event)
        self.flow.end()  # type: ignore[attr-defined]

    def connection_lost(self, exc: Exception | None) -> None:
        self._cancel_deadline()
        self.forget()
        self._crowd.leave(self, address_of(self.client))
        super().connection_lost(exc)
        self.flow.end()  # type: ignore[attr-defined]
        release(self.transport)

    def _expect(self, what: str, within: float) -> None:
        """A deadline that runs is not put off by what trickles in."""
        if self._due != what:
            self._cancel_deadline()
            self._due, self._deadline = what, self.loop.call_later(within, self.transport.abort)

    def _cancel_deadline(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
        self._due, self._deadline = "", None


class TimeoutSocket(IncrementalProtocol, WebSocketsSansIOProtocol):
    """Lets little wait in the kernel, and goes when it is over, whether or not the peer reads."""

    def __init__(self, config: ServerConfig, *given: Any, **more: Any) -> None:
        IncrementalProtocol.__init__(self, config.crowd.parsing)
        WebSocketsSansIOProtocol.__init__(self, config, *given, **more)
        self._crowd = config.crowd
        self._accepted = False
        self._pings = RateCounter()
        self._gone = False

    def connection_made(self, transport: BaseTransport) -> None:
        """Bound what the kernel keeps for a peer that reads slowly."""
        super().connection_made(transport)
        raw: Any = transport.get_extra_info("socket")
        option = getattr(socket, "TCP_NOTSENT_LOWAT", None)
        if raw is not None and option is not None and raw.family in (socket.AF_INET, socket.AF_INET6):
            raw.setsockopt(socket.IPPROTO_TCP, option, MAX_UNSENT_BYTES)
        self._crowd.enter(self, address_of(self.client))

    @property
    def stranger(self) -> bool:
        return not self._accepted

    def data_received(self, data: bytes) -> None:
        """Something came. The handshake comes while the other protocol still listens: it is taken whole."""
        if self.handshake_initiated:
            self.arrived(data)
        else:
            self.take(data)

    @property
    def full(self) -> bool:
        return self.read_paused

    def take(self, piece: bytes) -> None:
        super().data_received(piece)

    def handle_ping(self) -> None:
        """Each is answered by itself, which takes as long as a message that someone counts."""
        if self._pings.add(time.monotonic()) > MOST_PINGS:
            self.transport.abort()
        else:
            super().handle_ping()

    async def receive(self) -> Any:
        """The next message; then what waits is parsed."""
        message = await super().receive()
        if not self.full:
            self.go_on_soon()
        return message

    async def send(self, message: Any) -> None:
        """A refusal by HTTP is a handshake that is complete, and no fault that the log should hold."""
        await super().send(message)
        if message["type"] == "websocket.accept":
            self._accepted = True
        elif message["type"] == "websocket.http.response.body" and not message.get("more_body", False):
            self.handshake_complete = True

    def connection_lost(self, exc: Exception | None) -> None:
        """It is over; a transport that is closed cannot be aborted any more."""
        self._gone = True
        self.forget()
        self._crowd.leave(self, address_of(self.client))
        super().connection_lost(exc)
        release(self.transport)

    def on_task_complete(self, task: Task[None]) -> None:
        """The conversation is over; the last bytes get a moment."""
        super().on_task_complete(task)
        self.loop.call_later(PARTING_S, self._part)

    def keepalive_timeout(self) -> None:
        """No pong came: the peer is gone, and so is whatever still waited for it."""
        super().keepalive_timeout()
        self.loop.call_later(PARTING_S, self._part)

    def shutdown(self) -> None:
        """The console ends; uvicorn's own way raises where the peer has just said good-bye."""
        if self.handshake_complete and self.conn.state is not State.OPEN:
            self.stop_keepalive()
            self.transport.close()
        else:
            super().shutdown()
        self.loop.call_later(PARTING_S / 4, self._part)

    def _part(self) -> None:
        if not self._gone:
            self.transport.abort()


def address_of(client: tuple[str, int] | None) -> str:
    return client[0] if client else ""


def release(transport: Any) -> None:
    """Let a transport that is over be freed at once: it holds a method of its own, and so itself.

    Thousands of connections of strangers would wait for the collector of garbage, which then takes 80 ms.
    """
    if hasattr(transport, "_read_ready_cb"):
        transport._read_ready_cb = None


def send_at_once(transport: BaseTransport) -> None:
    """No byte waits for the other side to acknowledge an earlier one."""
    raw: Any = transport.get_extra_info("socket")
    if raw is not None and raw.family in (socket.AF_INET, socket.AF_INET6):
        raw.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
