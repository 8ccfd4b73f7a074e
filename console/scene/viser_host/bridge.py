"""From our socket to viser's conversation: two loops in two threads, every frame crosses once."""

import asyncio
import contextlib
import time

from starlette.websockets import WebSocket, WebSocketDisconnect

from console.access.logins import Person
from console.http.rate_counter import RateCounter, size_of
from console.scene.viser_host.connection import Connection, allowed
from console.scene.viser_host.mount import NoSocketServer
from console.workers.tasks import end

MOST_PER_SECOND = 300  # messages of a browser, of whatever kind: turning the view takes about 120
MOST_BYTES = 2**17  # a second; turning the view takes some 40,000
PARTING_S = 2.0  # for viser to take leave of a browser


class Bridge:
    def __init__(self, socket: WebSocket, inside: NoSocketServer, person: Person, tab: str) -> None:
        self._socket = socket
        self._inside = inside
        self._person = person
        self._over = asyncio.Event()
        self._tally, self._volume = RateCounter(), RateCounter()
        self._why = (1000, "")
        subprotocol = next((name for name in socket.scope["subprotocols"] if name.startswith("viser-v")), None)
        web = asyncio.get_running_loop()

        async def send(frame: bytes) -> None:
            crossing = asyncio.run_coroutine_threadsafe(socket.send_bytes(frame), web)
            await asyncio.wrap_future(crossing)

        self._connection = Connection(subprotocol, send, person=person, tab=tab)

    def close(self, code: int, reason: str) -> None:
        self._why = (code, reason)
        self._over.set()

    async def run(self) -> None:
        assert self._inside.loop is not None
        await self._socket.accept(subprotocol=self._connection.subprotocol)
        running = asyncio.run_coroutine_threadsafe(self._inside.run(self._connection), self._inside.loop)
        conversation = asyncio.wrap_future(running)
        pump, over = asyncio.create_task(self._pump()), asyncio.create_task(self._over.wait())
        try:
            await asyncio.wait({pump, over, conversation}, return_when=asyncio.FIRST_COMPLETED)
        finally:
            gone = pump.done() and not self._over.is_set()
            await end(pump, over)
            self._on_viser(self._connection.eof)
            with contextlib.suppress(Exception):
                async with asyncio.timeout(PARTING_S):
                    await asyncio.shield(conversation)
        if not gone:
            with contextlib.suppress(TimeoutError, WebSocketDisconnect, RuntimeError):
                async with asyncio.timeout(1.0):
                    await self._socket.close(*self._why)

    async def _pump(self) -> None:
        while True:
            message = await self._socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            if self._tally.add(time.monotonic()) > MOST_PER_SECOND:
                self.close(1008, f"More than {MOST_PER_SECOND} messages a second.")
                return
            if self._volume.add(time.monotonic(), size_of(message)) > MOST_BYTES:
                self.close(1008, f"More than {MOST_BYTES} bytes a second.")
                return
            raw = message.get("bytes")
            if raw is not None and allowed(raw, self._person):
                self._on_viser(self._connection.feed, raw)

    def _on_viser(self, act: object, *given: object) -> None:
        assert self._inside.loop is not None
        with contextlib.suppress(RuntimeError):
            self._inside.loop.call_soon_threadsafe(act, *given)  # type: ignore[arg-type]
