"""Bytes to and from a device on a serial port or a TCP connection, closed from any thread."""

from __future__ import annotations

import contextlib
import math
import os
import re
import select
import socket
import threading
import time
from collections.abc import Collection
from typing import TYPE_CHECKING
from urllib.parse import parse_qsl, unquote, urlsplit

from core.errors import BadInput, Unavailable
from core.install import install_extra
from core.message import message

if TYPE_CHECKING:
    from serial import Serial

CHUNK_BYTES = 65536  # bytes that are read at once, at most
CONNECT_TIMEOUT_S = 3.0  # until a TCP connection stands
READ_TIMEOUT_S = 0.05  # for which a serial port waits at a time
WRITE_TIMEOUT_S = 0.05  # after which what cannot be written is a lost link
HARDWARE = f"Serial ports need the package pyserial of the extra hardware: {install_extra('hardware')}"
WINDOWS_PORT = re.compile(r"com\d+$", re.I)  # a serial port, not a host


@message
class LinkAddress:
    """Address of a device: a serial port or a host, and options."""

    port_path: str = ""  # of the serial port; "": TCP
    host: str = ""
    port: int = 0
    options: dict[str, str]

    @property
    def name(self) -> str:
        """For sentences: `/dev/ttyUSB0` or `host:port`."""
        return self.port_path or f"{self.host}:{self.port}"

    def number(self, key: str, default: float, low: float, high: float) -> float:
        """An option that is a number from `low` to `high`. Raises BadInput."""
        text = self.options.get(key)
        if text is None:
            return default
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not low <= value <= high:
            raise BadInput(f"{key} must be a number from {low:g} to {high:g}.")
        return value

    def whole(self, key: str, default: int, low: int, high: int) -> int:
        """An option that is a whole number from `low` to `high`. Raises BadInput."""
        value = self.number(key, default, low, high)
        if value != int(value):
            raise BadInput(f"{key} must be a whole number.")
        return int(value)


def link_address(
    rest: str, example: str, keys: Collection[str], *, tcp_port: int, serial: bool = True
) -> LinkAddress:
    """Read the part of a URL after its scheme (`///dev/ttyUSB0?baud=115200`, `//host:10940`) → the address.

    `example`: a URL that is right, for the sentence. `keys`: the options there are. `tcp_port`: the usual one.
    `serial`: a serial port will do. Raises BadInput.
    """
    wrong = BadInput(f"This robot's address cannot be read; it looks like {example}.")
    try:
        parts = urlsplit(f"x:{rest}")
        host, port = parts.hostname or "", parts.port
    except ValueError:
        raise wrong from None
    options = dict(parse_qsl(parts.query, keep_blank_values=True))
    unknown = next((key for key in options if key not in keys), None)
    if unknown is not None:
        known = ", ".join(sorted(keys)) or "none"
        raise BadInput(f"{example.partition(':')[0]}: has no option {unknown[:40]!r}; known are {known}.")
    windows_port = WINDOWS_PORT.match(parts.netloc) and parts.path in ("", "/")
    if serial and (windows_port or (not parts.netloc and parts.path.strip("/"))):
        return LinkAddress(port_path=parts.netloc or unquote(parts.path), options=options)
    if not host or parts.path not in ("", "/"):
        raise wrong
    return LinkAddress(host=host, port=tcp_port if port is None else port, options=options)


class TcpLink:
    """A TCP connection. One thread reads, any thread writes and closes."""

    def __init__(self, host: str, port: int) -> None:
        """Connect. Raises Unavailable with a sentence."""
        try:
            self._socket = socket.create_connection((host, port), CONNECT_TIMEOUT_S)
        except OSError as trouble:
            raise Unavailable(f"{host}:{port} cannot be reached: {trouble.strerror or trouble}.") from None
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._writer = self._socket.dup()  # with a time-out of its own
        self._writer.settimeout(WRITE_TIMEOUT_S)

    def read(self, timeout: float) -> bytes:
        """Bytes that came, or b"" when nothing did within `timeout` [s]. Raises OSError when the link is gone."""
        self._socket.settimeout(max(timeout, 1e-4))
        try:
            data = self._socket.recv(CHUNK_BYTES)
        except TimeoutError:
            return b""
        if not data:
            raise ConnectionResetError("the other side hung up")
        return data

    def write(self, data: bytes) -> None:
        """Send all of it, without waiting for more than `WRITE_TIMEOUT_S`. Raises OSError when the link is gone."""
        self._writer.sendall(data)

    def close(self) -> None:
        """Let go; a `read` under way ends. Harmless when done twice."""
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._writer.close()
        self._socket.close()


class SerialLink:
    """A serial port, used as a TcpLink is."""

    def __init__(self, path: str, baud: int, *, dtr: bool = True) -> None:
        """Open the port at `baud` [bit/s], with the line DTR as said. Raises Unavailable with a sentence."""
        self._port = _open_port(path, baud, dtr)
        self._reading, self._writing = threading.Lock(), threading.Lock()
        self._closed = False

    def read(self, timeout: float) -> bytes:
        """As of TcpLink."""
        end = time.monotonic() + timeout
        with self._reading:
            while True:
                self._check()
                first = self._port.read(1)
                self._check()
                if first:
                    return first + self._port.read(min(self._port.in_waiting, CHUNK_BYTES))
                if time.monotonic() >= end:
                    return b""

    def write(self, data: bytes) -> None:
        """As of TcpLink."""
        with self._writing:
            self._check()
            if os.name == "posix":
                _write_all(self._port.fileno(), data)
            else:
                self._port.write(data)

    def close(self) -> None:
        """As of TcpLink."""
        if self._closed:
            return
        self._closed = True
        self._port.cancel_read()
        with self._reading, self._writing:
            self._port.close()

    def _check(self) -> None:
        if self._closed:
            raise OSError("the port was closed")


def _write_all(port: int, data: bytes) -> None:
    """Write to a file descriptor. Raises TimeoutError while it takes nothing.

    pyserial's own `write` counts the time for which this process got no processor, and raises after all was written.
    """
    end, left = time.monotonic() + WRITE_TIMEOUT_S, memoryview(data)
    while left:
        if not select.select((), (port,), (), max(end - time.monotonic(), 0.0))[1]:
            raise TimeoutError("the port takes no more bytes")
        left = left[os.write(port, left) :]


def _open_port(path: str, baud: int, dtr: bool) -> Serial:
    try:
        from serial import Serial
    except ModuleNotFoundError:
        raise Unavailable(f"{HARDWARE}.") from None
    try:
        port = Serial(baudrate=baud, timeout=READ_TIMEOUT_S, write_timeout=WRITE_TIMEOUT_S, exclusive=True)
        port.port, port.dtr = path, dtr
        port.open()
        return port
    except (OSError, ValueError) as trouble:
        raise Unavailable(_why_not(path, str(trouble))) from None


def _why_not(path: str, trouble: str) -> str:
    if "Errno 2]" in trouble:
        return f"There is no serial port {path}; is the cable plugged in?"
    if "Errno 13]" in trouble:
        return f"The serial port {path} may not be opened; on Linux: sudo adduser $USER dialout, then log in again."
    if "lock" in trouble:
        return f"The serial port {path} is in use by another program; close that first."
    return f"The serial port {path} cannot be opened."


class NoLink:
    """The link of a device that is not open."""

    def read(self, timeout: float) -> bytes:
        """Raises OSError."""
        raise OSError("the link is closed")

    def write(self, data: bytes) -> None:
        """Raises OSError."""
        raise OSError("the link is closed")

    def close(self) -> None:
        """Do nothing."""


ByteLink = TcpLink | SerialLink | NoLink


def drain(link: ByteLink, quiet: float, longest: float) -> None:
    """Read until nothing came for `quiet` [s], for `longest` [s] at most. Raises OSError."""
    end = time.monotonic() + longest
    while link.read(quiet) and time.monotonic() < end:
        pass


def open_link(address: LinkAddress, baud: int, *, dtr: bool = True) -> ByteLink:
    """Open the serial port as SerialLink does, or connect to the host. Raises Unavailable with a sentence."""
    if address.port_path:
        return SerialLink(address.port_path, baud, dtr=dtr)
    return TcpLink(address.host, address.port)
