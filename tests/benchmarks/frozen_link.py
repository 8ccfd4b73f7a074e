"""A TCP link that can be frozen: it then keeps what it is given, and loses nothing."""

from __future__ import annotations

import asyncio
import threading
from types import TracebackType


class FrozenLink:
    """Listens on a port of its own and passes everything on to `target`, unless frozen."""

    def __init__(self, target: int) -> None:
        self._target = target
        self._loop = asyncio.new_event_loop()
        self._open = asyncio.Event()
        self.port = 0

    def __enter__(self) -> FrozenLink:
        started = threading.Event()

        async def listen() -> None:
            self._open.set()
            server = await asyncio.start_server(self._pass_on, "127.0.0.1", 0)
            self.port = server.sockets[0].getsockname()[1]
            started.set()

        def run() -> None:
            asyncio.set_event_loop(self._loop)
            self._loop.create_task(listen())
            self._loop.run_forever()

        self._thread = threading.Thread(target=run, daemon=True)
        self._thread.start()
        started.wait(5)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None
    ) -> None:
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(2)

    def freeze(self) -> None:
        """Keep everything from now on."""
        self._loop.call_soon_threadsafe(self._open.clear)

    def flow(self) -> None:
        """Let through what was kept and all that follows."""
        self._loop.call_soon_threadsafe(self._open.set)

    async def _pass_on(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        far_reader, far_writer = await asyncio.open_connection("127.0.0.1", self._target)
        await asyncio.gather(self._one_way(reader, far_writer), self._one_way(far_reader, writer))

    async def _one_way(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            while piece := await reader.read(65536):
                await self._open.wait()
                writer.write(piece)
                await writer.drain()
        except ConnectionError:
            pass
        finally:
            await self._open.wait()
            writer.close()
