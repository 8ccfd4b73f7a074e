"""What arrives on a connection is parsed in small pieces, each connection for a moment at a time.

One read brings up to 256 kB; parsed at once, the smallest chunks or frames in it would keep the event loop for a
third of a second.
"""

from __future__ import annotations

import time
from asyncio import AbstractEventLoop, Handle, Transport

PIECE = 512  # [bytes] parsed at once: some 85 of the smallest chunks or frames
TURN = 0.001  # [s] of parsing before everything else has its turn


class Piecemeal:
    """Base of a protocol: reads no further while something waits to be parsed."""

    loop: AbstractEventLoop
    transport: Transport

    def __init__(self) -> None:
        self._unread = bytearray()
        self._next: Handle | None = None

    def take(self, piece: bytes) -> None:
        """Parse a piece."""
        raise NotImplementedError

    @property
    def full(self) -> bool:
        """Whether what was parsed has to be dealt with first."""
        raise NotImplementedError

    @property
    def replaced(self) -> bool:
        """Whether another protocol has taken the connection over; it gets nothing of what came before."""
        return False

    def arrived(self, data: bytes) -> None:
        """Bytes from the other side."""
        self._unread += data
        if self._next is None:
            self.go_on()

    def go_on_soon(self) -> None:
        """What was parsed is dealt with; what waits is due."""
        if self._unread and self._next is None:
            self._next = self.loop.call_soon(self.go_on)

    def go_on(self) -> None:
        """Parse what waits, for a moment."""
        self._next = None
        begun, at = time.monotonic(), 0
        while at < len(self._unread) and not self.full and time.monotonic() - begun < TURN:
            piece = bytes(self._unread[at : at + PIECE])
            at += PIECE
            self.take(piece)
            if self.transport.is_closing():
                self._unread.clear()
                return
            if self.replaced:
                self._unread.clear()
                self.transport.resume_reading()
                return
        del self._unread[:at]
        if not self._unread:
            if not self.full:
                self.transport.resume_reading()
            return
        self.transport.pause_reading()
        if not self.full:
            self.go_on_soon()
