"""A robot's console through the fleet: its page is the fleet's own files, what is in it comes from the robot.

Requests go on under a key of that console for this person. Nothing of a robot is ever a document of the fleet's
address: what it sends is shown as data alone.
"""

from __future__ import annotations

import asyncio
import contextlib
import ssl
from collections.abc import AsyncIterator, Callable
from typing import Any
from urllib.parse import SplitResult, quote, urlsplit

import h11
import websockets
from starlette.types import Receive, Scope, Send
from websockets.asyncio.client import ClientConnection, connect

from console.access.guard import SAFE_METHODS, refuse
from console.access.logins import Person
from console.access.open_sockets import SERVICE_RESTART, TooMany
from console.access.roles import needs
from console.control.durable_answers import URGENT
from console.fleet.bus import FleetKeyAnswer, trusting
from console.fleet_server.runtime import FleetRuntime, RobotRole
from console.http.problems import Problem
from console.options import LOOPBACK, in_address
from core.errors import BadInput
from core.sentences import Statement

CONNECT_TIMEOUT_S = 3.0
ANSWER_TIMEOUT_S = 60.0
ROLE_PERIOD_S = 0.5  # between looks whether the role of who has a socket open is still the same
CHUNK_BYTES = 65_536
DATA_ALONE = (b"content-security-policy", b"sandbox; default-src 'none'; frame-ancestors 'self'")
HANDED_ON = frozenset(
    b"accept accept-encoding accept-language content-type content-length if-none-match if-modified-since "
    b"range user-agent".split()
)
KEPT_BACK = frozenset(
    b"connection keep-alive transfer-encoding upgrade set-cookie content-security-policy server date "
    b"proxy-authenticate www-authenticate".split()
)


@needs("viewer", reads_body=False)
class RobotConsoles:
    """Mounted below `/robots`: everything but the pages themselves."""

    def __init__(self, runtime: FleetRuntime) -> None:
        self._runtime = runtime

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        name, _, path = scope["path"].removeprefix("/robots/").partition("/")
        try:
            if scope["type"] == "websocket":
                await self._socket(name, f"/{path}", scope, receive, send)
            else:
                await self._request(name, f"/{path}", scope, receive, send)
        except Problem as problem:
            await refuse(scope, receive, send, problem)

    async def _address(self, name: str, who: Person, *, renew: bool = False) -> tuple[SplitResult, FleetKeyAnswer]:
        """The address of a robot's console, and a key for it. Raises Problem 403, 404, 503."""
        robot = self._runtime.router.table.robots.get(name)
        if robot is None:
            raise Problem(404, Statement("fleet.unknown_name", name=name[:40]))
        if self._runtime.role_at(who, name) is None:
            raise Problem(403, Statement("fleet.not_let_in", name=name))
        if robot.report is None:
            raise Problem(503, Statement("fleet.robot_away", name=name))
        address = urlsplit(robot.report.address)
        if address.scheme != "https" and in_address(address.hostname or "") not in LOOPBACK:
            raise Problem(503, Statement("fleet.console_in_clear", name=name, address=address.netloc))
        key = await self._runtime.key_of(who, name, renew=renew)
        if key is None:
            raise Problem(503, Statement("fleet.robot_away", name=name))
        return address, key

    async def _request(self, name: str, path: str, scope: Scope, receive: Receive, send: Send) -> None:
        who: Person = scope["person"]
        if (scope["method"], path) == ("POST", "/api/login"):
            raise Problem(409, Statement("fleet.signs_in"))
        if scope["method"] not in SAFE_METHODS and path not in URGENT and (delay := self._runtime.hold_up_s):
            raise Problem(503, Statement("command.too_late", delay=f"{delay:.0f}"))
        body = _body(receive)
        upstream, key = await self._open(name, who)
        try:
            status, headers = await upstream.ask(scope["method"], path, scope, key, body)
            if status == 401:  # its console was restarted, or the key has ended
                await self._runtime.key_of(who, name, renew=True)
                raise Problem(503, Statement("fleet.key_renewed", name=name))
            await send({"type": "http.response.start", "status": status, "headers": [*headers, DATA_ALONE]})
            async for part in upstream.rest():
                await send({"type": "http.response.body", "body": part, "more_body": True})
            await send({"type": "http.response.body", "body": b""})
        finally:
            upstream.close()

    async def _open(self, name: str, who: Person) -> tuple[Upstream, str]:
        """Connect with a robot's console, and a key for it; once more where it may have taken another certificate."""
        refusal = Problem(503, Statement("fleet.robot_away", name=name))
        for renew in (False, True):
            address, key = await self._address(name, who, renew=renew)
            try:
                return await Upstream.open(address, name, key), key.token
            except (ssl.SSLError, ValueError) as why:
                refusal = _not_known(address, name, why)
        raise refusal

    async def _socket(self, name: str, path: str, scope: Scope, receive: Receive, send: Send) -> None:
        who: Person = scope["person"]
        await receive()  # the request to connect
        try:
            role = self._runtime.role_at(who, name)
            there = await self._dial(name, path, scope, who)
        except Problem as problem:
            await send({"type": "websocket.close", "code": 1013, "reason": problem.detail[:120]})
            return

        ended: asyncio.Future[tuple[int, str]] = asyncio.get_running_loop().create_future()

        def close(code: int, reason: str) -> None:
            if not ended.done():
                ended.set_result((code, reason))

        watch = asyncio.ensure_future(self._watch_role(who, name, role, close))
        try:
            with self._runtime.sockets.room_for(who, close):
                await send({"type": "websocket.accept", "subprotocol": there.subprotocol})
                code, reason = await _joined(there, receive, send, ended)
        except TooMany as why:
            code, reason = 1013, str(why)
        finally:
            watch.cancel()
            await there.close()
        with contextlib.suppress(RuntimeError):  # the browser was first
            await send({"type": "websocket.close", "code": code, "reason": reason})

    async def _watch_role(self, who: Person, name: str, role: RobotRole, close: Callable[[int, str], None]) -> None:
        """End a socket whose person has another role at this robot by now: its key is of the former one."""
        try:
            while self._runtime.role_at(who, name) == role:
                await asyncio.sleep(ROLE_PERIOD_S)
        except BadInput as why:
            close(1008, str(why)[:120])
            return
        close(1008, Statement("fleet.role_changed", name=name))

    async def _dial(self, name: str, path: str, scope: Scope, who: Person) -> ClientConnection:
        """Open a socket of a robot's console; once more with a new key where the old one is refused."""
        refusal = Problem(503, Statement("fleet.robot_away", name=name))
        for renew in (False, True):
            address, key = await self._address(name, who, renew=renew)
            query = scope["query_string"].decode("latin-1")
            scheme = "wss" if address.scheme == "https" else "ws"
            try:
                return await connect(
                    f"{scheme}://{address.netloc}{quote(path)}{'?' if query else ''}{query}",
                    additional_headers={"Authorization": f"Bearer {key.token}"},
                    subprotocols=scope.get("subprotocols") or None,
                    ssl=trusting(key.certificate) if scheme == "wss" else None,
                    compression=None,
                    proxy=None,
                    max_size=None,
                    open_timeout=CONNECT_TIMEOUT_S,
                    ping_interval=None,
                )
            except websockets.InvalidStatus as refused:
                if refused.response.status_code != 401:
                    raise _unreached(address, name) from None
            except (ssl.SSLError, ValueError) as why:
                refusal = _not_known(address, name, why)
            except (OSError, TimeoutError, websockets.WebSocketException):
                raise _unreached(address, name) from None
        raise refusal


class Upstream:
    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter, address: SplitResult) -> None:
        self._reader, self._writer, self._address = reader, writer, address
        self._line = h11.Connection(h11.CLIENT)

    @classmethod
    async def open(cls, address: SplitResult, name: str, key: FleetKeyAnswer) -> Upstream:
        """Connect. Raises Problem 503; SSLError or ValueError where it is not this robot's, with nothing said."""
        context = trusting(key.certificate) if address.scheme == "https" else None
        port = address.port or (80 if context is None else 443)
        try:
            async with asyncio.timeout(CONNECT_TIMEOUT_S):
                streams = await asyncio.open_connection(address.hostname, port, ssl=context, limit=CHUNK_BYTES)
        except ssl.SSLError:
            raise
        except (OSError, TimeoutError):
            raise _unreached(address, name) from None
        return cls(*streams, address)

    async def ask(
        self, method: str, path: str, scope: Scope, key: str, body: AsyncIterator[bytes]
    ) -> tuple[int, list[tuple[bytes, bytes]]]:
        """Send a request → status and headers of the answer. Raises Problem 503."""
        query = scope["query_string"]
        target = quote(path).encode() + (b"?" + query if query else b"")
        headers = [(name, value) for name, value in scope["headers"] if name in HANDED_ON]
        if any(name == b"transfer-encoding" for name, _ in scope["headers"]):
            headers.append((b"transfer-encoding", b"chunked"))
        own = [(b"host", self._address.netloc.encode()), (b"authorization", f"Bearer {key}".encode())]
        try:
            await self._write(h11.Request(method=method, target=target, headers=[*own, *headers]))
            async for part in body:
                await self._write(h11.Data(data=part))
            await self._write(h11.EndOfMessage())
            async with asyncio.timeout(ANSWER_TIMEOUT_S):
                while not isinstance(event := await self._event(), h11.Response):
                    if isinstance(event, h11.ConnectionClosed):
                        raise ConnectionResetError
        except (OSError, TimeoutError, h11.ProtocolError):
            where = self._address.netloc
            raise Problem(503, Statement("fleet.console_silent", address=where)) from None
        return event.status_code, [(name, value) for name, value in event.headers if name not in KEPT_BACK]

    async def rest(self) -> AsyncIterator[bytes]:
        while True:
            event = await self._event()
            if isinstance(event, h11.Data):
                yield bytes(event.data)
            elif isinstance(event, h11.EndOfMessage | h11.ConnectionClosed):
                return

    def close(self) -> None:
        self._writer.close()

    async def _write(self, event: Any) -> None:
        if (data := self._line.send(event)) is not None:
            self._writer.write(data)
            await self._writer.drain()

    async def _event(self) -> Any:
        while (event := self._line.next_event()) is h11.NEED_DATA:
            self._line.receive_data(await self._reader.read(CHUNK_BYTES))
        return event


async def _body(receive: Receive) -> AsyncIterator[bytes]:
    more = True
    while more:
        message = await receive()
        if message["type"] == "http.disconnect":
            raise ConnectionResetError
        if message.get("body"):
            yield message["body"]
        more = message.get("more_body", False)


async def _joined(
    there: ClientConnection, receive: Receive, send: Send, ended: asyncio.Future[tuple[int, str]]
) -> tuple[int, str]:
    """Hand messages both ways until one side closes, or it is ended → code and reason."""

    async def up() -> tuple[int, str]:
        while True:
            message = await receive()
            if message["type"] == "websocket.disconnect":
                return message.get("code") or 1000, message.get("reason") or ""
            text = message.get("text")
            await there.send(message["bytes"] if text is None else text)

    async def down() -> tuple[int, str]:
        async for message in there:
            kind = "text" if isinstance(message, str) else "bytes"
            await send({"type": "websocket.send", kind: message})
        return there.close_code or SERVICE_RESTART, there.close_reason or ""

    ways = [asyncio.ensure_future(up()), asyncio.ensure_future(down())]
    try:
        done, _ = await asyncio.wait([*ways, ended], return_when=asyncio.FIRST_COMPLETED)
        try:
            return done.pop().result()
        except (websockets.ConnectionClosed, OSError, RuntimeError):
            return there.close_code or SERVICE_RESTART, there.close_reason or ""
    finally:
        for way in ways:
            way.cancel()
        await asyncio.gather(*ways, return_exceptions=True)


def _unreached(address: SplitResult, name: str) -> Problem:
    return Problem(503, Statement("fleet.console_unreached", name=name, address=address.netloc))


def _not_known(address: SplitResult, name: str, why: ValueError | ssl.SSLError) -> Problem:
    """The refusal of a console that did not show the certificate that its robot named."""
    if isinstance(why, ssl.SSLCertVerificationError) and "expired" in why.verify_message:
        return Problem(503, Statement("fleet.console_expired", name=name, address=address.netloc))
    if isinstance(why, ssl.SSLError):
        return Problem(503, Statement("fleet.console_not_known", name=name, address=address.netloc))
    return Problem(503, Statement("fleet.console_unnamed", name=name, address=address.netloc))
