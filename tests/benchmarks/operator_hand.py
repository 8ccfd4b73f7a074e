"""A page's hand without a page: holds a drive key over the console's socket until its process is killed or frozen.

python -m tests.benchmarks.operator_hand PORT [PORT OF A LINK TO IT [KEY]]
"""

import asyncio
import contextlib
import json
import secrets
import socket
import sys
import time

from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed

from tests.benchmarks.command import print_row


async def hold(port: int, through: int, key: str = "") -> None:
    """Press once, then echo the newest nonce 20 times a second, as the page does."""
    line = socket.create_connection(("127.0.0.1", through))
    url, origin = f"ws://127.0.0.1:{port}/ws", f"http://127.0.0.1:{port}"
    headers = {"Authorization": f"Bearer {key}"} if key else {}
    options = {"sock": line, "origin": origin, "compression": None, "additional_headers": headers}
    async with connect(url, **options) as console:  # type: ignore[arg-type]
        gate: dict[str, int] = {}

        async def listen() -> None:
            with contextlib.suppress(ConnectionClosed):
                async for message in console:
                    if isinstance(message, str):
                        told = json.loads(message)
                        if told["kind"] == "state":
                            gate.update(nonce=told["gate"]["nonce"], epoch=told["gate"]["epoch"])

        listening = asyncio.create_task(listen())
        await console.send(json.dumps({"kind": "lease", "do": "take", "ref": 1}))
        press = secrets.randbelow(2**40)  # as on the page: a press is never drawn twice, and frames count on
        seq = time.time_ns() // 1_000_000
        for _ in range(6):
            await asyncio.sleep(0.05)
            seq += 1
            await console.send(drive(0.0, seq, press, gate))
        print_row("holding")
        while not listening.done():
            seq += 1
            await console.send(drive(0.12, seq, press + 1, gate))
            await asyncio.sleep(0.05)


def drive(v: float, seq: int, press: int, gate: dict[str, int]) -> str:
    """One drive message that turns on the spot a little as it goes, so that it never arrives anywhere."""
    w = 0.8 if v else 0.0
    return json.dumps({"kind": "drive", "v": v, "w": w, "press": press, "seq": seq, **gate})


if __name__ == "__main__":
    asyncio.run(hold(int(sys.argv[1]), int(sys.argv[2] if len(sys.argv) > 2 else sys.argv[1]), *sys.argv[3:]))
