"""viser inside this process: it binds no socket, our own sockets are handed to it.

viser 1.x always opens a TCP port of its own, without login and without an Origin check. So the name `websockets` is
replaced inside the one module of viser that opens the port; the real package stays as it is. Because that seam is a
private name, `open_viser` tries it out and never hangs: when it does not hold, there is no 3-D scene, and a loud line
says so.
"""

from __future__ import annotations

import asyncio
import contextlib
import importlib
import io
import secrets
import threading
import time
from collections.abc import Awaitable, Callable
from types import SimpleNamespace
from typing import Any

import viser
import viser._messages as viser_messages
import websockets
import websockets.asyncio.server
import websockets.datastructures
import websockets.exceptions

from console.scene.viser_host.connection import Connection
from console.workers.tasks import end
from core.errors import Unavailable

PREFIX = "beckon-inproc:"
MAX_BUILD_S = 30.0  # for viser to start: a busy computer takes many times the usual half second
MAX_PROBE_S = 10.0  # for a first frame
SUBPROTOCOL = f"viser-v{viser.__version__}"

seam: Any = importlib.import_module("viser.infra._infra")

Handler = Callable[[Connection], Awaitable[None]]
_captured: dict[str, NoSocketServer] = {}


class NoSocketServer:
    """The websocket server that viser believes to run. Lives on viser's loop."""

    def __init__(self, handler: Handler, host: str) -> None:
        self._handler = handler
        self._host = host
        self._live: dict[Connection, asyncio.Task[None] | None] = {}
        self.loop: asyncio.AbstractEventLoop | None = None

    async def __aenter__(self) -> Any:
        """Nothing is bound."""
        self.loop = asyncio.get_running_loop()
        _captured[self._host] = self
        return SimpleNamespace(server=SimpleNamespace(sockets=()))

    async def run(self, connection: Connection) -> None:
        """viser's conversation with one browser."""
        self._live[connection] = asyncio.current_task()
        try:
            await self._handler(connection)
        finally:
            self._live.pop(connection, None)

    async def __aexit__(self, *_: object) -> None:
        """End all conversations and wait for them, as the real server does."""
        _captured.pop(self._host, None)
        tasks = [task for task in self._live.values() if task is not None]
        for connection in list(self._live):
            connection.eof()
        if tasks:
            await asyncio.wait(tasks, timeout=1.0)
        await end(*tasks)


class QuietViser(viser.ViserServer):
    """viser without its tunnel to the outside."""

    def request_share_url(self, verbose: bool = True) -> str | None:
        return None

    def disconnect_share_url(self) -> None:
        """There is none."""


def open_viser() -> tuple[QuietViser, NoSocketServer]:
    """viser, mounted and tried out. Blocks for MAX_BUILD_S and MAX_PROBE_S at most. Raises Unavailable."""
    install()
    host = f"{PREFIX}{secrets.token_hex(8)}"
    built: list[QuietViser] = []
    builder = threading.Thread(target=lambda: built.append(build(host)), name="viser-start", daemon=True)
    builder.start()
    builder.join(MAX_BUILD_S)
    inside = _captured.get(host)
    if builder.is_alive():
        raise Unavailable(f"The 3-D scene is left out: viser did not start within {MAX_BUILD_S:g} s.")
    if not built or inside is None or built[0].get_port() != 0:
        raise Unavailable("The 3-D scene could not be mounted: this version of viser starts differently.")
    if not probe(inside):
        raise Unavailable("The 3-D scene was mounted but says nothing.")
    return built[0], inside


def build(host: str) -> QuietViser:
    """Make the server; what viser prints is not for the operator."""
    with contextlib.redirect_stdout(io.StringIO()):
        server = QuietViser(host=host, port=0, verbose=False)
    for message in (viser_messages.ShareUrlRequest, viser_messages.ShareUrlDisconnect):
        websocket_server(server).unregister_handler(message)
    server.gui.configure_theme(show_logo=False, show_share_button=False)
    return server


def websocket_server(server: QuietViser) -> Any:
    """viser's own record of who is connected."""
    inner: Any = server
    return inner._websock_server


def install() -> None:
    """Put our stand-in at the seam, once."""
    if isinstance(seam.websockets, SimpleNamespace):
        return
    real = websockets.asyncio.server

    def serve(handler: Any, host: Any = None, port: Any = None, **options: Any) -> Any:
        if isinstance(host, str) and host.startswith(PREFIX):
            return NoSocketServer(handler, host)
        return real.serve(handler, host, port, **options)

    seam.websockets = SimpleNamespace(
        asyncio=SimpleNamespace(server=SimpleNamespace(serve=serve, ServerConnection=real.ServerConnection)),
        datastructures=websockets.datastructures,
        exceptions=websockets.exceptions,
        Headers=websockets.datastructures.Headers,
    )


def probe(inside: NoSocketServer) -> bool:
    """Return whether a browser would get a first frame."""
    assert inside.loop is not None
    heard: list[int] = []

    async def listen(frame: bytes) -> None:
        heard.append(len(frame))

    connection = Connection(SUBPROTOCOL, listen)
    running = asyncio.run_coroutine_threadsafe(inside.run(connection), inside.loop)
    end = time.monotonic() + MAX_PROBE_S
    while not heard and time.monotonic() < end and not running.done():
        time.sleep(0.01)
    inside.loop.call_soon_threadsafe(connection.eof)
    with contextlib.suppress(Exception):
        running.result(MAX_PROBE_S)
    return bool(heard) and heard[0] > 16


def close_viser(server: QuietViser) -> None:
    """Stop it; joins its thread."""
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()
