"""Wires for emulators: a pseudo-terminal or a TCP port, on which one device answers one driver."""

import contextlib
import os
import select
import socket
import threading
import time
import tty
from abc import ABC, abstractmethod
from collections.abc import Callable
from pathlib import Path

import numpy as np
from websockets.sync.server import Server

LOST: OSError = ConnectionResetError("the wire was cut")


class Wire:
    """Bytes in both directions. `rate` [bit/s] is that of the serial line behind it, 10 bit a byte; 0: no limit.

    `lossy`: what nobody reads is lost, as on a serial line; else it waits, as on TCP.
    """

    def __init__(
        self, descriptor: int, *, rate: int, lossy: bool, mangle: Callable[[bytes], bytes] | None = None
    ) -> None:
        self._descriptor, self._rate, self._lossy = descriptor, rate, lossy
        self._mangle = mangle
        self._sending = threading.Lock()
        self.cut = threading.Event()

    def read(self, timeout: float) -> bytes:
        """What came, or b"" after `timeout` [s]. Raises OSError when the wire is cut."""
        end = time.monotonic() + timeout
        while not self.cut.is_set():
            left = end - time.monotonic()
            if select.select([self._descriptor], [], [], min(max(left, 0.0), 0.02))[0]:
                data = os.read(self._descriptor, 65536)
                if data:
                    return data
                raise LOST
            if left <= 0:
                return b""
        raise LOST

    def write(self, data: bytes, *, mangled: bool = True) -> None:
        """Send, at the line's rate. Raises OSError when the wire is cut."""
        with self._sending:
            self._send(self._mangle(data) if self._mangle and mangled else data)

    def close(self) -> None:
        """Write nothing from now on, the descriptor may be another's soon."""
        self.cut.set()
        with self._sending:
            pass

    def _send(self, data: bytes) -> None:
        size = max(1, self._rate // 10 // 200) if self._rate else 4096
        began, sent = time.monotonic(), 0
        while sent < len(data):
            if self.cut.is_set():
                raise LOST
            if not select.select([], [self._descriptor], [], 0.02)[1]:
                if self._lossy:
                    return
                continue
            with contextlib.suppress(BlockingIOError):
                sent += os.write(self._descriptor, data[sent : sent + size])
            if self._rate:
                time.sleep(max(0.0, began + 10 * sent / self._rate - time.monotonic()))


class Port(ABC):
    """Where drivers connect: serves one after another on a thread, can be shut and opened again."""

    url = ""  # what follows the scheme
    lossy = False

    def __init__(self, serve: Callable[[Wire], None], *, rate: int = 0) -> None:
        self.mangle: Callable[[bytes], bytes] | None = None
        self.wire: Wire | None = None
        self._serve, self._rate = serve, rate
        self._over = threading.Event()
        self._thread: threading.Thread | None = None

    def start(self) -> None:
        self._over.clear()
        self._open()
        self._thread = threading.Thread(target=self._run, name="emulator", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Be gone, as a device that was unplugged."""
        self._over.set()
        if self.wire is not None:
            self.wire.cut.set()
        self._close()
        if self._thread is not None:
            self._thread.join(5.0)

    def _run(self) -> None:
        while not self._over.is_set():
            with contextlib.suppress(OSError, ValueError):
                self._next()

    def _speak(self, descriptor: int) -> None:
        self.wire = Wire(descriptor, rate=self._rate, lossy=self.lossy, mangle=self._mangled)
        try:
            self._serve(self.wire)
        finally:
            self.wire.close()

    def inject(self, data: bytes) -> bool:
        """Send bytes as they are → whether a driver was there."""
        try:
            if self.wire is not None:
                self.wire.write(data, mangled=False)
                return True
        except OSError:
            pass
        return False

    def _mangled(self, data: bytes) -> bytes:
        return self.mangle(data) if self.mangle else data

    @abstractmethod
    def _open(self) -> None: ...

    @abstractmethod
    def _close(self) -> None: ...

    @abstractmethod
    def _next(self) -> None:
        """Serve one driver until it is gone."""


class SerialPort(Port):
    """A pseudo-terminal behind a link of a lasting name."""

    lossy = True

    def __init__(self, serve: Callable[[Wire], None], path: Path, *, rate: int = 0) -> None:
        super().__init__(serve, rate=rate)
        self.path = path
        self.url = f"//{path}"
        self._device = self._driver = -1

    def _open(self) -> None:
        self._device, self._driver = os.openpty()
        for end in (self._device, self._driver):
            tty.setraw(end)
            os.set_blocking(end, False)
        self.path.unlink(missing_ok=True)
        self.path.symlink_to(os.ttyname(self._driver))

    def _next(self) -> None:
        self._speak(self._device)

    def _close(self) -> None:
        self.path.unlink(missing_ok=True)
        if self._thread is not None:
            self._thread.join(5.0)
        for end in (self._device, self._driver):
            os.close(end)


class TcpPort(Port):
    def __init__(self, serve: Callable[[Wire], None], *, port: int = 0, rate: int = 0) -> None:
        super().__init__(serve, rate=rate)
        self._port = port
        self._listening: socket.socket | None = None

    def _open(self) -> None:
        self._listening = socket.create_server(("127.0.0.1", self._port))
        self._listening.settimeout(0.05)
        self._port = self._listening.getsockname()[1]
        self.url = f"//127.0.0.1:{self._port}"

    def _next(self) -> None:
        assert self._listening is not None
        try:
            connection, _ = self._listening.accept()
        except TimeoutError:
            return
        with connection:
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            connection.setblocking(False)
            self._speak(connection.fileno())

    def _close(self) -> None:
        if self._thread is not None:
            self._thread.join(5.0)
        if self._listening is not None:
            self._listening.close()


def bit_flips(rng: np.random.Generator, share: float) -> Callable[[bytes], bytes]:
    """Flip one bit in a `share` of the messages."""

    def mangle(data: bytes) -> bytes:
        if not data or rng.random() >= share:
            return data
        changed = bytearray(data)
        changed[rng.integers(len(changed))] ^= 1 << int(rng.integers(8))
        return bytes(changed)

    return mangle


def malformed(rng: np.random.Generator, good: bytes) -> bytes:
    """A message as no device sends it: cut, flipped, doubled, filled with chance, or nothing but chance."""
    kind = rng.integers(6)
    if kind == 0 or not good:
        return rng.integers(0, 256, int(rng.integers(1, 200)), dtype=np.uint8).tobytes()
    place = int(rng.integers(len(good)))
    if kind == 1:
        return good[:place]
    if kind == 2:
        return good[place:]
    if kind == 3:
        return good[:place] + good
    if kind == 4:
        return good[:place] + rng.integers(0, 256, 8, dtype=np.uint8).tobytes() + good[place:]
    changed = bytearray(good)
    for _ in range(int(rng.integers(1, 6))):
        changed[rng.integers(len(changed))] ^= 1 << int(rng.integers(8))
    return bytes(changed)


def serving(server: Server) -> threading.Thread:
    """The thread of a WebSocket server, begun; one that is shut down before it has begun to serve ends as quietly."""

    def serve() -> None:
        with contextlib.suppress(OSError):
            server.serve_forever()

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    return thread
