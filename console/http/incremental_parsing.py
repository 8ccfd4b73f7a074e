"""Incremental parsing: bytes of a connection are parsed in small pieces, each connection for a moment at a time.

One read brings up to 256 kB; parsed at once, the smallest chunks or frames in it would keep the event loop for a
third of a second.
"""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from asyncio import AbstractEventLoop, Handle, Transport

PIECE_BYTES = 256  # parsed at once: some 40 of the smallest chunks or frames
TURN_S = 0.001  # of parsing, by all connections with much to parse together, before everything else has its turn


class IncrementalProtocol(ABC):
    """Base of a protocol: reads no further while something waits to be parsed."""

    loop: AbstractEventLoop
    transport: Transport

    def __init__(self, parsing: set[IncrementalProtocol]) -> None:
        """`parsing`: all that have more to parse than a moment's work."""
        self._parsing = parsing
        self._unread = bytearray()
        self._next: Handle | None = None

    @abstractmethod
    def take(self, piece: bytes) -> None:
        """Parse a piece."""

    @property
    @abstractmethod
    def full(self) -> bool:
        """True if the parsed part has to be dealt with first."""

    @property
    def stranger(self) -> bool:
        """True while no request on it has shown a valid key or login."""
        return True

    @property
    def idle(self) -> bool:
        return False

    def drop(self, silence_s: float = 0.0) -> None:
        """End it, now or after a silence in which nothing is read: others need the place."""
        if silence_s:
            self.forget()
            self.transport.pause_reading()
            self.loop.call_later(silence_s, self.transport.abort)
        else:
            self.transport.abort()

    @property
    def piece(self) -> int:
        """How much may be parsed at once [bytes]."""
        return PIECE_BYTES

    @property
    def replaced(self) -> bool:
        """True if another protocol has taken the connection over; it gets none of the earlier bytes."""
        return False

    def arrived(self, data: bytes) -> None:
        self._unread += data
        if self._next is None:
            self.go_on()

    def go_on_soon(self) -> None:
        """The parsed part is dealt with; the waiting bytes are due."""
        if self._unread and self._next is None:
            self._next = self.loop.call_soon(self.go_on)

    def go_on(self) -> None:
        """Parse what waits, for a moment."""
        self._next = None
        end, at = time.monotonic() + TURN_S / max(len(self._parsing), 1), 0
        while at < len(self._unread) and not self.full and (at == 0 or time.monotonic() < end):
            piece = bytes(self._unread[at : at + self.piece])
            at += len(piece)
            self.take(piece)
            if self.replaced or self.transport.is_closing():
                self.forget()
                self.transport.resume_reading()
                return
        del self._unread[:at]
        if not self._unread:
            self._parsing.discard(self)
            if not self.full:
                self.transport.resume_reading()
            return
        self.transport.pause_reading()
        if self.full:
            self._parsing.discard(self)
        else:
            self._parsing.add(self)
            self.go_on_soon()

    def forget(self) -> None:
        self._unread.clear()
        self._parsing.discard(self)
