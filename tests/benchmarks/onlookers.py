"""Viewers' pages without pages: `python -m tests.benchmarks.onlookers PORT VIEWERS [KEY]`, until it is killed.

That many sockets read everything, and one more reads nothing.
"""

from __future__ import annotations

import asyncio
import sys

from websockets.asyncio.client import ClientConnection, connect


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

    reading = asyncio.gather(*(read(line) for line in opened[:-1]), return_exceptions=True)
    sys.stdout.write("watching\n")
    sys.stdout.flush()
    await reading


if __name__ == "__main__":
    asyncio.run(watch(int(sys.argv[1]), int(sys.argv[2]), *sys.argv[3:]))
