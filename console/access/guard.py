"""The guard: one plain ASGI class in front of every request and every socket.

Order: Host, what the route asks for, who it is, where it comes from (Origin), whether the role suffices, then the
body, counted while it streams. Denied unless all of it is good.
"""

import asyncio
import re
import time
from collections.abc import Awaitable, Callable, MutableMapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from starlette.routing import BaseRoute

from console.access.logins import ANYBODY, Logins, Person
from console.access.roles import JSON, BodyLimit, Requirement, need_for
from console.access.strict_json import read_json
from console.http.problems import Problem, wanted_page
from core.errors import BadInput
from core.sentences import Statement

Scope = MutableMapping[str, Any]
Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

AT_ONCE = 16384  # bytes of JSON that are read on the event loop; more would keep it for milliseconds
BODY_TIME_S = 10.0  # for an ordinary body
MOST_LARGE = 4  # bodies beyond what JSON may have that are taken in at the same time
ON_THIS_MACHINE = {"127.0.0.1", "::1", "::ffff:127.0.0.1"}
SAFE_METHODS = {"GET", "HEAD", "OPTIONS"}
HOST_NAME = re.compile(r"\[[0-9a-f:.]+\]|[a-z0-9._-]+")
HOST = re.compile(rf"({HOST_NAME.pattern})(:[0-9]{{1,5}})?")

PAGE_POLICY = "default-src 'self'; frame-ancestors 'none'; object-src 'none'; base-uri 'none'; form-action 'self'"

HEADERS = {
    b"content-security-policy": PAGE_POLICY.encode(),
    b"x-content-type-options": b"nosniff",
    b"referrer-policy": b"no-referrer",
    b"cross-origin-opener-policy": b"same-origin",
    b"cross-origin-resource-policy": b"same-origin",
    b"cache-control": b"no-store",
}


@dataclass(frozen=True)
class Access:
    logins: Logins = field(default_factory=Logins)
    hosts: frozenset[str] = frozenset({"127.0.0.1", "localhost", "[::1]"})
    cookie: str = "beckon_8420"  # the port in its name: cookies are shared between ports
    address: str = ""  # under which other machines open the console; "": this machine alone does
    no_auth: bool = False  # loopback and simulator only; Host and Origin are still checked


class Visit:
    def __init__(self, scope: Scope) -> None:
        self.socket = scope["type"] == "websocket"
        self.unsafe = self.socket or scope["method"] not in SAFE_METHODS
        self.scheme = {"ws": "http", "wss": "https"}.get(scope["scheme"], scope["scheme"])
        self.headers: dict[str, list[str]] = {}
        for name, value in scope["headers"]:
            self.headers.setdefault(name.decode("latin-1").lower(), []).append(value.decode("latin-1"))

    def one(self, name: str) -> str | None:
        """The header, when it is there. Raises Problem 400 when it stands twice."""
        values = self.headers.get(name, [])
        if len(values) > 1:
            raise Problem(400, f"The header {name} stands twice; send it once.")
        return values[0] if values else None

    def cookie(self, name: str) -> str | None:
        pairs = (pair.partition("=") for line in self.headers.get("cookie", ()) for pair in line.split(";"))
        return next((value.strip() for key, _, value in pairs if key.strip() == name), None)


class AccessGuard:
    """Lets in who may come in; tells everybody else why not."""

    def __init__(self, app: App, *, routes: Sequence[BaseRoute], access: Access) -> None:
        self.app = app
        self.routes = routes
        self.access = access
        self._large = 0  # bodies under way that may be large

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        dressed = send if scope["type"] == "websocket" else with_headers(send)
        try:
            believe_proxy(scope)
            visit = Visit(scope)
            host = self._check_host(visit)
            need = need_for(self.routes, scope)
            scope["person"] = person = self._recognise(visit, need)
            self._check_origin(visit, host)
            if person is not None and not person.may(need.role):
                raise Problem(403, Statement("access.needs_role", role=need.role, own=person.role))
            if not visit.socket and visit.unsafe and need.reads_body:
                receive = await self._take_body(visit, need.body, receive)
        except Problem as problem:
            await refuse(scope, receive, dressed, problem)
        except ClientGone:
            return
        else:
            await self.app(scope, receive, dressed)

    async def _take_body(self, visit: Visit, body: BodyLimit, receive: Receive) -> Receive:
        """Within the limits of one body, and of all large ones together. Raises Problem."""
        if body.most <= JSON.most:
            return await checked_body(visit, body, receive)
        if self._large >= MOST_LARGE:
            raise Problem(429, "Too many large bodies at once; send the next one when this one is answered.")
        self._large += 1
        try:
            return await checked_body(visit, body, receive)
        finally:
            self._large -= 1

    def _check_host(self, visit: Visit) -> str:
        host = (visit.one("host") or "").lower()
        shape = HOST.fullmatch(host)
        if shape is None:
            raise Problem(400, "The Host header is missing or malformed.")
        if shape[1] not in self.access.hosts:
            raise Problem(403, "This console does not answer to that host name; open it by the address it printed.")
        return host

    def _recognise(self, visit: Visit, need: Requirement) -> Person | None:
        person, shown = self._person(visit)
        if person is None and need.role != "public":
            detail = Statement("access.login_over") if shown else Statement("access.sign_in")
            raise Problem(401, detail, headers={"WWW-Authenticate": "Bearer"})
        return person

    def _person(self, visit: Visit) -> tuple[Person | None, bool]:
        """Return the person, and whether the request showed any credentials."""
        if self.access.no_auth:
            return ANYBODY, False
        shown = visit.one("authorization")
        if shown is not None:
            scheme, _, token = shown.partition(" ")
            if scheme.lower() != "bearer":
                return None, True
            return self.access.logins.bearer(token.strip(), time.monotonic()), True
        cookie = visit.cookie(self.access.cookie)
        if cookie is None:
            return None, False
        return self.access.logins.of_cookie(cookie, time.monotonic()), True

    def _check_origin(self, visit: Visit, host: str) -> None:
        if not visit.unsafe:
            return
        origin, site = visit.one("origin"), visit.one("sec-fetch-site")
        foreign = origin is not None and origin.lower() != f"{visit.scheme}://{host}"
        foreign = foreign or (site is not None and site != "same-origin")
        by_cookie = (
            not self.access.no_auth and visit.one("authorization") is None and visit.cookie(self.access.cookie)
        )
        unproven = by_cookie and origin is None and (visit.socket or site is None)
        if foreign or unproven:
            raise Problem(403, "This request does not come from the console's own page.")


def believe_proxy(scope: Scope) -> None:
    """A program on this machine that speaks TLS for us says so in a header; of whom it speaks is not believed."""
    forwarded = [value for name, value in scope["headers"] if name == b"x-forwarded-proto"]
    client = scope.get("client")
    if client and client[0] in ON_THIS_MACHINE and forwarded in ([b"http"], [b"https"]):
        secure = forwarded == [b"https"]
        scope["scheme"] = {"http": "http", "websocket": "ws"}[scope["type"]] + ("s" if secure else "")


class ClientGone(Exception):
    """The other side left before its request was complete."""


async def checked_body(visit: Visit, wanted: BodyLimit, receive: Receive) -> Receive:
    """Read a body within its limits; returns a receive that hands it on. Raises Problem 400, 408, 413, 415."""
    length = visit.one("content-length")
    if length is not None and (not length.isascii() or not length.isdigit()):
        raise Problem(400, "The Content-Length header is malformed.")
    if length is not None and int(length) > wanted.most:
        raise too_large(wanted)
    if (length not in (None, "0")) or "transfer-encoding" in visit.headers:
        check_type(visit, wanted)
    body = bytearray()
    try:
        async with asyncio.timeout(wanted.patience * BODY_TIME_S):
            more = True
            while more:
                message = await receive()
                if message["type"] == "http.disconnect":
                    raise ClientGone
                body += message.get("body", b"")
                more = message.get("more_body", False)
                if len(body) > wanted.most:
                    raise too_large(wanted)
    except TimeoutError:
        seconds = wanted.patience * BODY_TIME_S
        raise Problem(408, f"The request's body took longer than {seconds:.0f} seconds.") from None
    if body:
        check_type(visit, wanted)
        if wanted.is_json:
            await check_json(bytes(body))
    return replay(bytes(body), receive)


async def check_json(body: bytes) -> None:
    """Raises Problem 400 for a body that is not valid JSON."""
    try:
        if len(body) > AT_ONCE:
            await asyncio.to_thread(read_json, body)
        else:
            read_json(body)
    except BadInput as trouble:
        raise Problem(400, str(trouble)) from None


def too_large(wanted: BodyLimit) -> Problem:
    return Problem(413, f"The body is larger than {wanted.most} bytes.")


def check_type(visit: Visit, wanted: BodyLimit) -> None:
    """Raises Problem 415 unless the body is declared as one of the types that are taken; text in UTF-8, plain."""
    declared, _, parameters = (visit.one("content-type") or "").partition(";")
    charset = parameters.strip().lower().replace('"', "")
    if declared.strip().lower() not in wanted.types or charset not in ("", "charset=utf-8"):
        if wanted.is_json:
            raise Problem(415, "Send JSON, with the header Content-Type: application/json.")
        raise Problem(415, f"Send {' or '.join(wanted.types)}, and say so in the header Content-Type.")
    if "content-encoding" in visit.headers:
        raise Problem(415, "Send the body uncompressed.")


def replay(body: bytes, receive: Receive) -> Receive:
    """A receive that hands out `body` once, then the further messages."""
    waiting = True

    async def again() -> Message:
        nonlocal waiting
        if waiting:
            waiting = False
            return {"type": "http.request", "body": body, "more_body": False}
        return await receive()

    return again


def with_headers(send: Send) -> Send:
    """A send that adds the security headers a response does not set itself."""

    async def dressed(message: Message) -> None:
        if message["type"] == "http.response.start":
            message["headers"] = dress(message.get("headers", ()))
        await send(message)

    return dressed


def dress(headers: Sequence[tuple[bytes, bytes]]) -> list[tuple[bytes, bytes]]:
    """A response's headers and, for those it does not set, the security headers."""
    own = {name.lower() for name, _ in headers}
    return [*headers, *((name, value) for name, value in HEADERS.items() if name not in own)]


async def refuse(scope: Scope, receive: Receive, send: Send, problem: Problem) -> None:
    """Answer with a problem; a socket is refused before it opens."""
    kind = "http.response"
    root = wanted_page(scope) if problem.status == 401 else None
    if root is not None:  # the page there signs in
        problem = Problem(303, problem.detail, headers={"Location": root})
    if scope["type"] == "websocket":
        await receive()
        if "websocket.http.response" not in (scope.get("extensions") or {}):
            await send({"type": "websocket.close", "code": 1008, "reason": problem.detail})
            return
        kind = "websocket.http.response"
    await send({"type": f"{kind}.start", "status": problem.status, "headers": dress(problem.header_list())})
    await send({"type": f"{kind}.body", "body": problem.body()})
