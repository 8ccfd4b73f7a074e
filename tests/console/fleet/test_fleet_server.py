"""The fleet over HTTP, and a robot's console through it."""

import asyncio
import http.client
import json
import re
import shutil
import socket
import time
from collections.abc import Awaitable, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import msgspec
import pytest
import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket
from websockets.asyncio.client import connect
from websockets.exceptions import InvalidStatus

from console.access.guard import Access
from console.access.logins import Logins, Person
from console.access.records import AccessFile
from console.assembly import shown_certificate
from console.fleet.authority import Authority, CertificateFiles
from console.fleet.bus import FleetAddress, FleetKeyAnswer
from console.fleet.router import FleetRouter
from console.fleet_server.api import state
from console.fleet_server.runtime import FleetRuntime
from console.fleet_server.serve import create_fleet_app
from console.http.server import configured
from tests.emulators.light_console import LightConsole
from tests.emulators.zenoh_robot import free_port

pytestmark = pytest.mark.skipif(
    shutil.which("openssl") is None, reason="a certificate needs openssl: apt install openssl"
)


SEEN: list[str] = []  # keys that arrived


async def echo(request: Request) -> JSONResponse:
    """What came, and a cookie and a page that must not come through."""
    SEEN.append(request.headers["authorization"])
    seen = {**request.headers, "body": (await request.body()).decode(), "path": request.scope["path"]}
    return JSONResponse(seen, 201, {"set-cookie": "a=b", "content-security-policy": "default-src *"})


async def echo_socket(socket: WebSocket) -> None:
    await socket.accept()
    SEEN.append(socket.headers["authorization"])
    await socket.send_text(socket.headers["authorization"])
    await socket.send_bytes(await socket.receive_bytes())
    await socket.close(4001, "enough")


@asynccontextmanager
async def served(config: uvicorn.Config) -> Any:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        server = uvicorn.Server(config)
        task = asyncio.create_task(server.serve(sockets=[listener]))
        async with asyncio.timeout(60):
            while not server.started:
                await asyncio.sleep(0.01)
        try:
            yield listener.getsockname()[1]
        finally:
            server.should_exit = True
            await task


Reply = tuple[int, Any, bytes]


def ask(port: int, method: str, path: str, key: str, body: str | None) -> Reply:
    """Status, headers, body."""
    line = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
    shown = {"Authorization": f"Bearer {key}"} if key else {}
    line.request(method, path, body, shown | ({"Content-Type": "application/json"} if body else {}))
    answer = line.getresponse()
    found = answer.status, answer.headers, answer.read()
    line.close()
    return found


async def check_requests(
    asked: Callable[..., Awaitable[Reply]], console: LightConsole, runtime: FleetRuntime, robot: int
) -> None:
    """A request arrives under a key for this person with their role at this robot; the answer is no document."""
    status, headers, body = await asked("POST", "/robots/r1/api/commands?x=1", "operator", '{"text": "stop"}')
    seen = json.loads(body)
    assert (status, seen["path"], seen["body"]) == (201, "/api/commands", '{"text": "stop"}')
    person = console.logins.bearer(seen["authorization"].removeprefix("Bearer "), 1.0)
    assert person is not None and person.role == "operator"
    assert "set-cookie" not in headers and headers["content-security-policy"].startswith("sandbox")
    assert "cookie" not in seen and seen["host"] == f"127.0.0.1:{robot}"
    for name in ("big%20desk", "B%C3%BCro%3F", "a%25b"):
        seen = json.loads((await asked("GET", f"/robots/r1/api/places/{name}"))[2])
        assert seen["path"] == f"/api/places/{unquote(name)}"
    runtime.roles.set("operator", "r1", "viewer")
    seen = json.loads((await asked("GET", "/robots/r1/api/state", "operator"))[2])
    person = console.logins.bearer(seen["authorization"].removeprefix("Bearer "), 1.0)
    assert person is not None and person.role == "viewer"


async def check_certificate(
    asked: Callable[..., Awaitable[Reply]],
    console: LightConsole,
    runtime: FleetRuntime,
    port: int,
    key: str,
    another: str,
) -> None:
    """What does not show the certificate that the robot named gets no key: not by a request, not by a socket."""
    member, right, told = console.member, console.member._certificate, {"Authorization": f"Bearer {key}"}
    runtime._keys = {at: FleetKeyAnswer(key.token, another) for at, key in runtime._keys.items()}
    assert (await asked("POST", "/robots/r1/api/commands", "operator"))[0] == 201, "a console may change it"
    before = list(SEEN)
    for named, says in ((another, "does not show the certificate"), ("", "did not name its certificate")):
        runtime._keys.clear()
        member._certificate = named
        status, _, body = await asked("POST", "/robots/r1/api/commands", "operator", '{"text": "stop"}')
        assert status == 503 and says in json.loads(body)["detail"]
        with pytest.raises(InvalidStatus, match="403"):
            await connect(f"ws://127.0.0.1:{port}/robots/r1/ws", additional_headers=told, proxy=None)
    assert before == SEEN
    runtime._keys.clear()
    member._certificate = right


async def check_plain_http(
    asked: Callable[..., Awaitable[Reply]], console: LightConsole, runtime: FleetRuntime, port: int, key: str
) -> None:
    """A console on another computer that speaks plain HTTP is sent nothing, and gives no key."""
    member, robot = console.member, runtime.router.table.robots["r1"]
    right, member._address = member._address, "http://192.0.2.7:8420/"
    async with asyncio.timeout(60):
        while robot.report is None or robot.report.address != member._address:
            await asyncio.sleep(0.01)
    runtime._keys.clear()
    status, _, body = await asked("POST", "/robots/r1/api/stop", "operator")
    assert status == 503 and "192.0.2.7:8420 speaks plain HTTP" in json.loads(body)["detail"]
    with pytest.raises(InvalidStatus, match="403"):
        await connect(
            f"ws://127.0.0.1:{port}/robots/r1/ws", additional_headers={"Authorization": f"Bearer {key}"}, proxy=None
        )
    assert runtime._keys == {}
    member._address = right


async def check_socket(port: int, key: str, change_role: Callable[[], None]) -> None:
    """Texts and bytes go both ways, and how it ended is said; it ends with the role with which it was opened."""
    told = {"Authorization": f"Bearer {key}"}
    url = f"ws://127.0.0.1:{port}/robots/r1/ws"
    async with connect(url, additional_headers=told, proxy=None) as line:
        assert str(await line.recv()).startswith("Bearer ")
        await line.send(b"\x00\x01")
        assert await line.recv() == b"\x00\x01"
        await line.wait_closed()
        assert (line.close_code, line.close_reason) == (4001, "enough")
    async with connect(url, additional_headers=told, proxy=None) as line:
        await line.recv()
        change_role()
        async with asyncio.timeout(20):
            await line.wait_closed()
        assert (line.close_code, line.close_reason) == (1008, "Your role at r1 has changed.")


def test_each_role_does_what_it_may_and_a_console_is_opened_with_ones_own_role_as_data_alone(tmp_path: Path) -> None:
    authority = Authority(tmp_path)
    authority.prepare(("127.0.0.1",))
    authority.issue("r1", tmp_path / "r1", kind="robot")
    logins = Logins()
    keys = {role: logins.issue(role, role) for role in ("viewer", "operator")}
    address = FleetAddress("127.0.0.1", free_port())
    runtime = FleetRuntime(tmp_path, Access(logins), authority, address)
    upstream = Starlette(
        routes=[Route("/api/{rest:path}", echo, methods=["GET", "POST"]), WebSocketRoute("/ws", echo_socket)]
    )

    async def work() -> None:
        async with AsyncExitStack() as stack:
            own, another = CertificateFiles(tmp_path / "r1"), CertificateFiles(tmp_path / "router")
            tls = uvicorn.Config(upstream, log_config=None, ssl_certfile=own.certificate, ssl_keyfile=own.key)
            robot = await stack.enter_async_context(served(tls))
            port = await stack.enter_async_context(served(configured(create_fleet_app(runtime))))
            page, shown = f"https://127.0.0.1:{robot}/", shown_certificate(own.certificate)
            console = LightConsole("r1", address, own.folder, tmp_path / "r1-home", page=page, certificate=shown)
            console.open()
            stack.push_async_callback(console.close)

            async def asked(method: str, path: str, role: str = "viewer", body: str | None = None) -> Reply:
                return await asyncio.to_thread(ask, port, method, path, keys.get(role, ""), body)

            async with asyncio.timeout(60):
                while json.loads((await asked("GET", "/api/fleet"))[2])["robots"][0]["link"] != "live":
                    await asyncio.sleep(0.05)
            for path in ("/api/fleet", "/api/fleet/robots/r1/picture", "/robots/r1/api/state"):
                assert (await asked("GET", path, ""))[0] == 401, path
            assert json.loads((await asked("POST", "/api/fleet/stop"))[2])["all"] is True
            assert json.loads((await asked("POST", "/api/fleet/halt"))[2])["robots"][0]["acknowledged"] is True
            assert console.robot.status().state == "halted"
            assert (await asked("POST", "/api/fleet/halt/reset"))[0] == 403
            assert (await asked("POST", "/api/fleet/halt/reset", "operator"))[0] == 200
            assert (await asked("GET", "/api/fleet/robots/r1/picture"))[2].startswith(b"\xff\xd8")

            await check_requests(asked, console, runtime, robot)
            runtime._ticked_at -= 30.0  # as a process that stood still for so long
            stale = runtime.router._session
            late = await asked("POST", "/robots/r1/api/commands", "operator")
            assert re.search(rb"\b[3-9]\d s on its way", late[2])
            assert (await asked("POST", "/robots/r1/api/stop", "operator"))[0] == 201, "a stop never comes too late"
            while runtime.router._session in (stale, None) or runtime.router.table.robots["r1"].link != "live":
                await asyncio.sleep(0.01)  # it listens anew: connections that were given up meanwhile wait no more
            runtime._ticked_at, runtime._back_at = time.monotonic(), 0.0
            await check_socket(port, keys["operator"], lambda: runtime.roles.set("operator", "r1", "operator"))
            others = shown_certificate(another.certificate)
            await check_certificate(asked, console, runtime, port, keys["operator"], others)
            await check_plain_http(asked, console, runtime, port, keys["operator"])
            runtime.roles.set("viewer", "r1", None)
            for path in ("/robots/r1/api/state", "/api/fleet/robots/r1/picture"):
                assert (await asked("GET", path))[0] == 403, path
            assert (await asked("GET", "/robots/r9/api/state"))[0] == 404
            assert b"fleet-cards" in (await asked("GET", "/", ""))[2]
            assert (await asked("GET", "/robots/r1/", ""))[1]["location"] == "/"
            assert b"command-line" in (await asked("GET", "/robots/r1/", "operator"))[2]
            assert b'<main class="docs">' in (await asked("GET", "/robots/r1/static/docs/index.md", "operator"))[2]

    asyncio.run(work())


def test_a_part_of_the_fleet_that_ended_is_said_on_its_page(tmp_path: Path) -> None:
    authority, address = Authority(tmp_path), FleetAddress("127.0.0.1", free_port())
    runtime = FleetRuntime(tmp_path, Access(Logins()), authority, address)

    async def failing() -> None:
        raise AttributeError

    async def work() -> None:
        runtime._router = FleetRouter(authority, address)
        runtime._tasks.start(failing())
        await asyncio.sleep(0.01)
        assert (await state(runtime, Person("1", "Ann"))).trouble.startswith("A part of the fleet failed (Attr")

    asyncio.run(work())


def test_a_role_at_a_robot_outlives_the_key_that_it_was_given_to(tmp_path: Path) -> None:
    logins = Logins(AccessFile(tmp_path))
    authority, address = Authority(tmp_path), FleetAddress("127.0.0.1", free_port())
    runtime = FleetRuntime(tmp_path, Access(logins), authority, address)
    people = {}
    for key in ("guest", "Ann"):
        opened = logins.open(logins.issue(key, "operator", end=10.0), "Ann Other", 1.0)
        assert opened is not None
        people[key] = opened[1]
    runtime.roles.set("guest", "r1", None)

    def roles() -> list[str | None]:
        return [runtime.role_at(people[key], "r1") for key in ("guest", "Ann")]

    assert roles() == [None, "operator"]
    logins.expire(20.0)
    assert logins.all_keys() == [] and len(logins.all_logins()) == 2
    assert roles() == [None, "operator"]
    asyncio.run(runtime.close())
    kept = AccessFile(tmp_path).read()
    assert {one.key_name for one in kept.logins.values()} == {"guest", "Ann"}
    earlier = {at: msgspec.structs.replace(one, key_name="") for at, one in kept.logins.items()}
    logins._records.logins = earlier  # kept by an earlier console: nobody knows whose they are
    assert roles() == [None, None]
