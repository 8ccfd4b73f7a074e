"""Viewers' pages without pages: `python -m tests.benchmarks.onlookers PORT VIEWERS [KEY]`, until it is killed.

That many sockets read everything, one more reads nothing, and one 1 kB a second.
"""

import asyncio
import contextlib
import socket
import sys

from websockets.asyncio.client import ClientConnection, connect

from tests.benchmarks.command import print_row

SLOW_READ_BYTES = 1000  # a second


async def trickle(port: int, key: str) -> None:
    """A viewer at the end of a thin line; comes again when it is sent away."""
    head = f"GET /ws HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nOrigin: http://127.0.0.1:{port}\r\nConnection: Upgrade\r\n"
    upgrade = "Upgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
    asked = head + upgrade + (f"Authorization: Bearer {key}\r\n" if key else "") + "\r\n"
    loop = asyncio.get_running_loop()
    while True:
        with socket.socket() as line, contextlib.suppress(OSError):
            line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            line.setblocking(False)
            await loop.sock_connect(line, ("127.0.0.1", port))
            await loop.sock_sendall(line, asked.encode())
            while await loop.sock_recv(line, SLOW_READ_BYTES):
                await asyncio.sleep(1.0)
        await asyncio.sleep(1.0)


async def watch(port: int, viewers: int, key: str = "") -> None:
    """Open the sockets one after another, say so, and read."""
    url, origin = f"ws://127.0.0.1:{port}/ws", f"http://127.0.0.1:{port}"
    headers = {"Authorization": f"Bearer {key}"} if key else {}
    options = {"origin": origin, "compression": None, "ping_interval": None, "additional_headers": headers}
    opened = [await connect(url, **options) for _ in range(viewers + 1)]  # type: ignore[arg-type]
    opened[-1].transport.pause_reading()

    async def read(line: ClientConnection) -> None:
        async for _ in line:
            pass

    slow = trickle(port, key)
    reading = asyncio.gather(slow, *(read(line) for line in opened[:-1]), return_exceptions=True)
    print_row("watching")
    await reading


if __name__ == "__main__":
    asyncio.run(watch(int(sys.argv[1]), int(sys.argv[2]), *sys.argv[3:]))
