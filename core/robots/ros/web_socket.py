"""A WebSocket to a robot: one thread waits for its messages, any thread sends. No thread of its own.

The protocol is that of the package websockets; its own client keeps two more threads for every connection, which
costs more than all else where fifty robots send 65 messages a second each.
"""

import contextlib
import select
import socket
import ssl
import threading
import time
from collections.abc import Sequence
from typing import Any

from websockets.client import ClientProtocol
from websockets.exceptions import InvalidHandshake
from websockets.frames import DATA_OPCODES, Frame, Opcode
from websockets.http11 import Response
from websockets.protocol import CLOSED, OPEN
from websockets.typing import Subprotocol
from websockets.uri import parse_uri

RECEIVE_BYTES = 1 << 18  # that are taken from the system together
MAX_WAITING_BYTES = 1 << 20  # that are read before their messages are looked at
MAX_MESSAGE_BYTES = 1 << 26  # of a message
SEND_TIMEOUT_S = 1.0  # for which a robot may take nothing before the link counts as lost
PING_AFTER_S, PONG_TIMEOUT_S = 2.0, 5.0  # of silence after which the robot is asked, and for its answer
FAREWELL_S = 0.3  # for what was sent last to be taken, and for the other end to hang up
QUICK_ACK = getattr(socket, "TCP_QUICKACK", None)  # Linux has it


def acknowledge_at_once(end: socket.socket) -> None:
    """Have the system acknowledge what came and what comes next, where it can.

    A server that sends head and body of a message by themselves waits for that in between, up to 40 ms.
    """
    if QUICK_ACK is not None:
        with contextlib.suppress(OSError):
            end.setsockopt(socket.IPPROTO_TCP, QUICK_ACK, 1)


class WebSocket:
    """An open connection, until it is lost or closed; never used again afterwards."""

    def __init__(self, end: socket.socket, url: str, subprotocols: Sequence[str], patience: float) -> None:
        """Shake hands over a connected socket, which is encrypted already where it is to be.

        Raises OSError.
        """
        self._end, self._mutex = end, threading.Lock()
        self._protocol = ClientProtocol(
            parse_uri(url),
            subprotocols=[Subprotocol(name) for name in subprotocols] or None,
            max_size=MAX_MESSAGE_BYTES,
        )
        self._parts: list[bytes] = []  # of a message that comes in several
        self._is_text = False
        self._heard = self._asked = time.monotonic()  # [s] when something came last, and a ping was sent
        end.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        end.settimeout(SEND_TIMEOUT_S)
        acknowledge_at_once(end)
        try:
            self._waiting = self._shake_hands(patience)  # messages that came with the answer to the handshake
        except (InvalidHandshake, EOFError) as trouble:
            raise ConnectionAbortedError("the other end does not shake hands") from trouble

    def receive(self, patience: float) -> list[str | bytes]:
        """All messages that are there, or the next within `patience` [s]. Raises OSError when the link is lost."""
        arrived, self._waiting = self._waiting, []
        size = 0
        wait = 0.0 if arrived else patience
        while size < MAX_WAITING_BYTES and self._is_readable(wait):
            raw = self._read()
            size += len(raw)
            arrived += self._messages(self._feed(raw))
            wait = 0.0
        if self._protocol.state is CLOSED and not arrived:
            raise ConnectionResetError("the other end hung up")
        self._ask_for_life()
        return arrived

    def send(self, payload: str | bytes) -> None:
        """Send a message. Raises OSError when the link is lost."""
        with self._mutex:
            if self._protocol.state is not OPEN:
                raise ConnectionResetError("the link is closed")
            if isinstance(payload, str):
                self._protocol.send_text(payload.encode())
            else:
                self._protocol.send_binary(payload)
            self._flush()

    def close(self) -> None:
        """Let go, once what was sent before is with the other end; harmless when done twice."""
        with contextlib.suppress(OSError), self._mutex:
            if self._protocol.state is OPEN:
                self._protocol.send_close(1000)
                self._flush()
        with contextlib.suppress(OSError):
            self._end.shutdown(socket.SHUT_WR)
            until = time.monotonic() + FAREWELL_S
            while (
                (left := until - time.monotonic()) > 0 and self._is_readable(left) and self._end.recv(RECEIVE_BYTES)
            ):
                pass
        self._end.close()

    def _shake_hands(self, patience: float) -> list[str | bytes]:
        with self._mutex:
            self._protocol.send_request(self._protocol.connect())
            self._flush()
        until = time.monotonic() + patience
        while (left := until - time.monotonic()) > 0:
            events = self._feed(self._read()) if self._is_readable(left) else []
            if self._protocol.handshake_exc is not None:
                raise self._protocol.handshake_exc
            if events and isinstance(events[0], Response):
                return self._messages(events[1:])
        raise TimeoutError("the other end did not answer in time")

    def _is_readable(self, wait: float) -> bool:
        """Return whether something comes within that time [s]."""
        if isinstance(self._end, ssl.SSLSocket) and self._end.pending():
            return True
        coming = select.poll()  # one for each thread: the closing one looks, too
        try:
            coming.register(self._end, select.POLLIN)
        except ValueError:
            raise ConnectionResetError("the link is closed") from None
        return bool(coming.poll(1000 * wait))

    def _read(self) -> bytes:
        try:
            raw = self._end.recv(RECEIVE_BYTES)
        except TimeoutError:  # half a piece of an encrypted link
            return b""
        acknowledge_at_once(self._end)
        if not raw:
            raise ConnectionResetError("the other end hung up")
        self._heard = time.monotonic()
        return raw

    def _feed(self, raw: bytes) -> list[Any]:
        with self._mutex:
            if raw:
                self._protocol.receive_data(raw)
            events = self._protocol.events_received()
            self._flush()
        return events

    def _messages(self, events: Sequence[Any]) -> list[str | bytes]:
        found: list[str | bytes] = []
        for event in events:
            if not isinstance(event, Frame) or event.opcode not in DATA_OPCODES:
                continue
            if event.opcode is not Opcode.CONT:
                self._is_text, self._parts = event.opcode is Opcode.TEXT, []
            self._parts.append(bytes(event.data))
            if event.fin:
                whole = self._parts[0] if len(self._parts) == 1 else b"".join(self._parts)
                found.append(whole.decode(errors="replace") if self._is_text else whole)
                self._parts = []
        return found

    def _ask_for_life(self) -> None:
        """Send a ping where nothing comes any more. Raises OSError where none is answered."""
        now = time.monotonic()
        if now - self._heard > PING_AFTER_S + PONG_TIMEOUT_S:
            raise ConnectionResetError("the other end does not answer")
        if now - max(self._heard, self._asked) > PING_AFTER_S:
            self._asked = now
            with self._mutex:
                if self._protocol.state is OPEN:
                    self._protocol.send_ping(b"")
                    self._flush()

    def _flush(self) -> None:
        """Send what the protocol has to say. With the mutex held."""
        for raw in self._protocol.data_to_send():
            if raw:
                self._end.sendall(raw)
