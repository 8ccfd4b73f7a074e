"""A console that really listens, with a robot in this process, and raw ways to speak to it."""

from __future__ import annotations

import asyncio
import contextlib
import http.client
import json
import resource
import socket
import sys
import threading
import time
from collections.abc import Callable, Coroutine, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from fastapi import FastAPI
from websockets.sync.client import ClientConnection, connect
from websockets.sync.connection import Connection

from console.access.guard import Access
from console.access.logins import Logins
from console.app import create_app
from console.http.server import Server, configured
from console.recording.recorder import RecorderService
from console.runtime import Runtime
from console.speech.quality_runs import QualityRuns
from core.pilot import Pilot
from core.recording.settings import RecordingSettings
from core.robots.requests import SetListening
from tests.console.in_process import InProcessRobot

MORE = 100.0  # [s] that a busy machine may take


async def until(true: Callable[[], Any], seconds: float = MORE) -> Any:
    """Wait on the running loop for something to be the case → what it then is. Raises TimeoutError."""
    async with asyncio.timeout(seconds):
        while not (value := true()):
            await asyncio.sleep(0.01)
        return value


@dataclass
class Reply:
    """What came back over HTTP."""

    status: int
    headers: dict[str, str]
    body: bytes

    @property
    def json(self) -> Any:
        return json.loads(self.body)


class Served:
    """A server of this process on a port of its own, and raw ways to speak to it."""

    app: FastAPI
    server: Server
    operator: str
    viewer: str

    def __init__(self) -> None:
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = int(self.listener.getsockname()[1])
        self.cookie_name = f"beckon_{self.port}"
        self._thread = threading.Thread(target=self._run, daemon=True)

    def _run(self) -> None:
        asyncio.run(self._serve())

    async def _serve(self) -> None:
        self.loop = asyncio.get_running_loop()
        await self.server.serve(sockets=[self.listener])

    def on_loop(self, act: Callable[[], Any]) -> Any:
        """Do something on the console's event loop."""

        async def acting() -> Any:
            return act()

        return asyncio.run_coroutine_threadsafe(acting(), self.loop).result(MORE)

    def run(self, work: Coroutine[Any, Any, Any]) -> Any:
        """Do something on the console's event loop that waits."""
        return asyncio.run_coroutine_threadsafe(work, self.loop).result(MORE)

    # HTTP

    def ask(
        self,
        method: str,
        path: str,
        body: Any = None,
        *,
        token: str | None = None,
        raw: bytes | None = None,
        headers: dict[str, str] | None = None,
        host: str | None = None,
    ) -> Reply:
        """One request; `raw` goes as it is, `body` as JSON."""
        content = raw if raw is not None else None if body is None else json.dumps(body).encode()
        told = {"Host": host or f"127.0.0.1:{self.port}"}
        if content is not None:
            told["Content-Type"] = "application/json"
            told["Content-Length"] = str(len(content))
        if token is not None:
            told["Authorization"] = f"Bearer {token}"
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=MORE)
        try:
            connection.putrequest(method, path, skip_host=True, skip_accept_encoding=True)
            for name, value in {**told, **(headers or {})}.items():
                connection.putheader(name, value)
            connection.endheaders(content)
            answer = connection.getresponse()
            names = {name.lower(): value for name, value in answer.getheaders()}
            return Reply(answer.status, names, answer.read())
        finally:
            connection.close()

    def speak(self, head: bytes, *, wait: float = 5.0) -> bytes:
        """Raw bytes to the port → all that comes until the other side closes or falls silent."""
        with socket.create_connection(("127.0.0.1", self.port), timeout=wait) as line:
            line.sendall(head)
            heard = b""
            try:
                while part := line.recv(65536):
                    heard += part
                    if b"\r\n\r\n" in heard and b"101 Switching" in heard[:40]:
                        break
            except (TimeoutError, ConnectionResetError):
                pass
            return heard

    def knock(self, path: str, *headers: str, host: str | None = None) -> int:
        """A websocket handshake → the HTTP status it is answered with."""
        lines = [
            f"GET {path} HTTP/1.1",
            f"Host: {host or f'127.0.0.1:{self.port}'}",
            "Connection: Upgrade",
            "Upgrade: websocket",
            "Sec-WebSocket-Version: 13",
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==",
            *headers,
        ]
        heard = self.speak(("\r\n".join(lines) + "\r\n\r\n").encode())
        return int(heard.split(b" ", 2)[1])

    # sockets

    def open(self, path: str = "/ws", *, token: str | None = None, **options: Any) -> ClientConnection:
        """A socket as a script opens it."""
        headers = {"Authorization": f"Bearer {token or self.operator}"}
        options = {"compression": None, "max_size": None, "proxy": None, **options}
        return connect(f"ws://127.0.0.1:{self.port}{path}", additional_headers=headers, **options)


class Live(Served):
    """The console between `with` and its end."""

    def __init__(
        self,
        folder: Path,
        *,
        no_auth: bool = False,
        url: str = "sim:lab",
        make_pilot: Any = None,
        tls: tuple[Path, Path] | None = None,
        pace: float = 1.0,
        ring_s: float = 0.0,
        from_start: bool = False,
        foxglove_port: int = 0,
    ) -> None:
        """`ring_s`: of the recorder, whose process starts with the first motion; `from_start`: at once.

        `foxglove_port`: it serves there.
        """
        self.home = folder
        self.robot = InProcessRobot(url, pace=pace)
        logins = Logins()
        self.operator = logins.issue("operator", "operator")
        self.admin = logins.issue("operator", "admin")
        self.viewer = logins.issue("viewer", "viewer")
        super().__init__()
        access = Access(logins, cookie=self.cookie_name, no_auth=no_auth)
        self.runtime = Runtime(
            self.robot, make_pilot or (lambda: Pilot(self.robot.profile)), home=folder, access=access
        )
        self.runtime.parts[RecorderService]._settings = RecordingSettings(ring_s=ring_s, from_start=from_start)
        self.runtime.parts[RecorderService].foxglove_port = foxglove_port
        self.app = create_app(self.runtime)
        self.server = Server(configured(self.app, *(tls or ())), self.runtime, lambda: None)

    def __enter__(self) -> Live:
        self._thread.start()
        self.until(lambda: self.server.started and self.runtime.snapshot is not None)
        return self

    def __exit__(self, *_: object) -> None:
        self.runtime.shut_down_soon()
        self.server.should_exit = True
        self._thread.join(MORE)
        assert not self._thread.is_alive(), "the console did not end"
        assert self.robot.faults() == []

    def until(self, true: Callable[[], Any], seconds: float = 20.0) -> Any:
        """Wait for something to be the case → what it then is.

        `seconds` also of the robot's clock, which waits for a slow computer; where that one stands, MORE of ours.
        """
        begun, robot = time.monotonic(), self.robot.now
        while not (value := true()):
            waited = time.monotonic() - begun
            late = waited > seconds + MORE or self.robot.now - robot > seconds
            assert waited < seconds or not late, "it never came"
            time.sleep(0.01)
        return value

    def calm(self) -> None:
        """As it was at the start: nobody drives, nothing is latched, nothing is under way."""

        async def end_runs() -> None:
            for run in self.runtime.parts[QualityRuns].runs.values():
                await self.runtime.parts[QualityRuns].cancel(run)

        def act() -> None:
            runtime = self.runtime
            if self.robot.status().state == "halted":
                self.robot.reset()
            if runtime.lease.holder is not None:
                runtime.dispatcher.forget(runtime.lease.holder)

        asyncio.run_coroutine_threadsafe(end_runs(), self.loop).result(MORE)
        self.on_loop(act)
        if self.robot.profile.microphones is not None:  # it listens for a minute after somebody spoke
            self.robot.ask(SetListening(on=False))


def hear(line: Connection, kind: str, *, seconds: float = MORE, true: Callable[[Any], Any] = bool) -> Any:
    """The next message of a kind that is as wanted."""
    end = time.monotonic() + seconds
    while True:
        message = line.recv(timeout=max(0.01, end - time.monotonic()))
        if isinstance(message, str):
            told = json.loads(message)
            if told["kind"] == kind and true(told):
                return told


def say(line: Connection, **message: Any) -> None:
    """One message up."""
    line.send(json.dumps(message))


def say_at_once(line: ClientConnection, texts: Iterable[str]) -> None:
    """Many messages up in one write: however slow this machine is, they arrive together."""
    for text in texts:
        line.protocol.send_text(text.encode())
    line.socket.sendall(b"".join(line.protocol.data_to_send()))


@contextlib.contextmanager
def full_disk(most: int = 128) -> Iterator[None]:
    """No file of this process, and of those it starts meanwhile, grows beyond `most` bytes; modules are not compiled.

    Python does not notice that a compiled module was cut off, and the next process could not import it.
    """
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONDONTWRITEBYTECODE", "1")
        patch.setattr(sys, "dont_write_bytecode", True)
        resource.setrlimit(resource.RLIMIT_FSIZE, (most, hard))
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
