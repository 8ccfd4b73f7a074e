"""uvicorn as a console and a fleet run it: prompt at its end, and bounded."""

import asyncio
import contextlib
import os
import signal
import socket
import threading
from collections.abc import Callable, Generator
from functools import partial
from pathlib import Path
from types import FrameType
from typing import Any, Protocol

import uvicorn
from starlette.types import ASGIApp

from console.http.connection_limits import MAX_CONNECTIONS, ConnectionLimits
from console.http.timeouts import HEADER_TIME_S, ServerConfig, TimeoutHttp, TimeoutSocket
from core.errors import Unavailable

SOCKET_MESSAGE_BYTES = 16384  # at most in one message: the longest sentence takes 12,000
ACCEPTED_AT_ONCE = 16  # connections: each is read before a crowd of strangers behind it can push it out again
MAX_WAITING_CONNECTIONS = 1024  # that wait to be accepted; beyond, a client tries again after a whole second
PING_PERIOD_S = 5.0  # between pings, and for an answer to one


class Endable(Protocol):
    """The work behind a server, which hears of its end."""

    trouble: str  # why it could not start, a sentence

    def shut_down(self) -> None: ...

    def shut_down_soon(self) -> None:
        """The same from a signal handler or any thread."""
        ...


class Server(uvicorn.Server):
    """uvicorn that tells every stream first when it is asked to end."""

    def __init__(self, config: uvicorn.Config, runtime: Endable, listening: Callable[[], None]) -> None:
        super().__init__(config)
        self._runtime = runtime
        self._listening = listening

    async def startup(self, sockets: list[socket.socket] | None = None) -> None:
        """Listening; now the address can be shown."""
        loop: Any = asyncio.get_running_loop()
        if self.config.ssl is not None:  # uvicorn hands no such bound on
            loop.create_server = partial(loop.create_server, ssl_handshake_timeout=HEADER_TIME_S)
        await super().startup(sockets)
        for listener in (each for server in self.servers for each in server.sockets):
            with socket.socket(fileno=os.dup(listener.fileno())) as own:
                own.listen(MAX_WAITING_CONNECTIONS)  # asyncio made the queue as long as what is accepted at once
        self._listening()

    @contextlib.contextmanager
    def capture_signals(self) -> Generator[None]:
        """The terminal that was closed ends the console as orderly as Ctrl-C, unless it was started by nohup."""
        on_main = threading.current_thread() is threading.main_thread()
        if on_main and signal.getsignal(signal.SIGHUP) == signal.SIG_DFL:
            signal.signal(signal.SIGHUP, self.handle_exit)
        with super().capture_signals():
            yield

    def leave(self) -> None:
        """End as after a signal; on the event loop."""
        self._runtime.shut_down()
        self.should_exit = True

    def handle_exit(self, sig: int, frame: FrameType | None) -> None:
        """A signal arrived: only word is left here, the event loop does the rest."""
        self._runtime.shut_down_soon()
        super().handle_exit(sig, frame)


def run_until_left(server: Server, listener: socket.socket, runtime: Endable) -> bool:
    """Serve → True; False after an interrupt. Raises Unavailable with a sentence where the robot does not come."""
    try:
        server.run(sockets=[listener])
    except KeyboardInterrupt:
        return False
    except SystemExit:
        if server.should_exit:  # a signal came while the robot was being opened
            return False
        raise Unavailable(runtime.trouble or "The console could not start; the log says why.") from None
    return True


def configured(
    app: ASGIApp, certificate: Path | None = None, key: Path | None = None, most: int = MAX_CONNECTIONS
) -> ServerConfig:
    """How uvicorn runs this application; by HTTPS where there is a certificate; `most` connections at a time."""
    config = ServerConfig(
        app,
        ssl_certfile=certificate,
        ssl_keyfile=key,
        http=TimeoutHttp,
        ws=TimeoutSocket,
        ws_per_message_deflate=False,
        ws_max_size=SOCKET_MESSAGE_BYTES,
        backlog=ACCEPTED_AT_ONCE,
        ws_ping_interval=PING_PERIOD_S,
        ws_ping_timeout=PING_PERIOD_S,
        timeout_graceful_shutdown=3,
        access_log=False,
        server_header=False,
        proxy_headers=False,  # the guard reads the one that counts
        log_config=None,
        lifespan="on",
    )
    config.crowd = ConnectionLimits(most)
    return config
