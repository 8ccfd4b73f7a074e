"""One stranger in a process of its own: `python -m tests.benchmarks.attacker KIND PORT [KEY]`, until it is killed.

Without a key: `bodies` of 1 MB, `chunks` of one byte each, `half` requests that are never completed, a `loris` that
trickles, bad `sockets` that send frames before they are let in. With a viewer's key, on a socket: a `flood` of large
messages, messages that keep `within` the size of one, empty `pings`.
"""

import asyncio
import contextlib
import json
import os
import sys
import time
from collections.abc import AsyncIterator, Awaitable, Callable

from websockets.asyncio.client import ClientConnection, connect
from websockets.exceptions import ConnectionClosed, InvalidHandshake

BODY = b"[" + b"1," * 499_000 + b"1]"
HALF_OPEN = 300  # connections that one stranger holds
TRICKLING = 100
PIECES = 40_000  # chunks of one byte in one blow
PINGS = 20_000  # empty frames in one blow
FLOOD = 190  # messages a second, below what is allowed
MESSAGES = {"flood": 60_000, "within": 15_000}  # bytes of each


def post(*headers: str) -> bytes:
    """The head of a login."""
    lines = ["POST /api/login HTTP/1.1", "Host: 127.0.0.1", "Content-Type: application/json", *headers]
    return ("\r\n".join(lines) + "\r\n\r\n").encode()


async def bodies(port: int) -> None:
    """A megabyte to whoever asks for a token, again and again."""
    await ask(port, post(f"Content-Length: {len(BODY)}") + BODY)


async def chunks(port: int) -> None:
    """The same in the smallest pieces there are."""
    await ask(port, post("Transfer-Encoding: chunked") + b"1\r\n1\r\n" * PIECES)


async def sockets(port: int) -> None:
    """A socket without a key that speaks before it is let in."""
    head = "GET /ws HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
    key = "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    await ask(port, (head + key).encode(), b"\x89\x80\x00\x00\x00\x00" * PINGS)


async def ask(port: int, *parts: bytes) -> None:
    """One connection: say it all, wait for any answer."""
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    try:
        for part in parts:
            writer.write(part)
            await asyncio.sleep(0.001)
        async with asyncio.timeout(5.0):
            await reader.read(1)
    finally:
        writer.transport.abort()


async def half(port: int) -> None:
    """Connections held open with half a request; a new one for each that is closed."""
    await hold(port, HALF_OPEN, trickle=False)


async def loris(port: int) -> None:
    """Requests whose heads grow by a line 20 times a second and never end."""
    await hold(port, TRICKLING, trickle=True)


async def hold(port: int, number: int, *, trickle: bool) -> None:
    """Hold `number` of unfinished requests."""

    async def one() -> None:
        while True:
            with contextlib.suppress(OSError):
                reader, writer = await asyncio.open_connection("127.0.0.1", port)
                writer.write(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n")
                while trickle and not writer.is_closing():
                    await asyncio.sleep(0.05)
                    writer.write(b"X: 1\r\n")
                await reader.read(1)
                writer.transport.abort()
            await asyncio.sleep(0.05)

    await asyncio.gather(*(one() for _ in range(number)))


async def flood(port: int, key: str, kind: str = "flood") -> None:
    """As many messages of this size as one socket may send; again when it is closed."""
    size = MESSAGES[kind] // 2 - 20
    text = json.dumps({"kind": "echo", "t": 1, "x": [1] * size}, separators=(",", ":"))
    async with watching(port, key) as line:
        due = time.monotonic()
        while True:
            await line.send(text)
            due += 1 / FLOOD
            await asyncio.sleep(max(0.0, due - time.monotonic()))


async def within(port: int, key: str) -> None:
    """The same with messages of moderate size."""
    await flood(port, key, "within")


async def pings(port: int, key: str) -> None:
    """Frames that no application sees."""
    async with watching(port, key) as line:
        while True:
            line.transport.write(b"\x89\x80\x00\x00\x00\x00" * PINGS)
            await asyncio.sleep(0.05)


@contextlib.asynccontextmanager
async def watching(port: int, key: str) -> AsyncIterator[ClientConnection]:
    """A viewer's socket that reads everything, while it is open."""
    headers = {"Authorization": f"Bearer {key}"}
    address = f"ws://127.0.0.1:{port}/ws"
    with contextlib.suppress(ConnectionClosed, InvalidHandshake):
        async with connect(address, additional_headers=headers, compression=None, proxy=None, max_size=None) as line:
            reading = asyncio.create_task(drain(line))
            try:
                yield line
            finally:
                reading.cancel()


async def drain(line: ClientConnection) -> None:
    """Read what comes."""
    with contextlib.suppress(ConnectionClosed):
        async for _ in line:
            pass


STRANGERS: dict[str, Callable[..., Awaitable[None]]] = {
    "bodies": bodies,
    "chunks": chunks,
    "sockets": sockets,
    "half": half,
    "loris": loris,
    "flood": flood,
    "within": within,
    "pings": pings,
}


async def attack(kind: str, port: int, *key: str) -> None:
    """Without end."""
    while True:
        with contextlib.suppress(OSError, TimeoutError):
            await STRANGERS[kind](port, *key)
        await asyncio.sleep(0.001)


if __name__ == "__main__":
    os.nice(5)  # what is measured is the console, not who gets the processor
    asyncio.run(attack(sys.argv[1], int(sys.argv[2]), *sys.argv[3:]))
