"""The guard: every way in, every host, every origin, every role."""

import re
import shutil
import time
from collections.abc import Iterator

import msgspec
import pytest
from fastapi import FastAPI
from starlette.routing import BaseRoute, Mount, Route, WebSocketRoute
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from console.access.guard import HEADERS
from console.access.logins import fingerprint
from console.access.roles import check_roles, declared, needs
from console.api.page import PAGE_NAMES
from console.fleet_server.proxy import RobotConsoles
from console.scene.viser_host.mount import SUBPROTOCOL
from tests.console.live import Live, Served, hear, say
from tests.console.live_fleet import LiveFleet

BODYLESS = {"content-length": "0"}


@pytest.fixture(scope="module")
def live_fleet(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveFleet]:
    if shutil.which("openssl") is None:
        pytest.skip("a certificate needs openssl: apt install openssl")
    with LiveFleet(tmp_path_factory.mktemp("fleet")) as fleet:
        yield fleet


@pytest.fixture(params=["live", "live_fleet"])
def door(request: pytest.FixtureRequest) -> Served:
    """A console, and a fleet: one guard stands before both."""
    return request.getfixturevalue(request.param)


def address(route: BaseRoute) -> str:
    path = str(getattr(route, "path", ""))
    return re.sub(r"\{\w+\}", "1", path) + ("/main.js" if isinstance(route, Mount) else "")


def ways_in(app: FastAPI) -> Iterator[tuple[str, str, str]]:
    """(method or WS, address, role) of every route."""
    for route in app.routes:
        need = declared(route)
        assert need is not None
        if isinstance(route, WebSocketRoute) or type(route).__name__ == "APIWebSocketRoute":
            yield "WS", address(route), need.role
        elif isinstance(route, Mount):
            yield "GET", address(route), need.role
            if isinstance(route.app, RobotConsoles):
                yield from (("POST", "/robots/1/api/commands", need.role), ("WS", "/robots/1/ws", need.role))
        else:
            assert isinstance(route, Route)
            for method in sorted((route.methods or {"GET"}) - {"HEAD"}):  # it is answered as GET is
                yield method, address(route), need.role


PAGE_PATHS = [f"{page}{end}" for page in PAGE_NAMES for end in ("", ".html")]
PUBLIC = {("GET", "/"), ("GET", "/static/docs/{path:path}"), ("GET", "/static/main.js"), ("POST", "/api/login")}
PUBLIC_OF = {
    "Live": {
        *(("GET", f"/{path}") for path in PAGE_PATHS),
        ("GET", "/api/health"),
        ("GET", "/metrics"),  # for programs on this machine; others are asked who they are
    },
    "LiveFleet": {
        *(("GET", f"/robots/1/{path}") for path in ("", "static/main.js", "static/docs/{path:path}", *PAGE_PATHS))
    },
}


def test_every_way_in_but_the_door_itself_refuses_a_stranger(door: Served) -> None:
    public = set()
    for method, path, role in ways_in(door.app):
        if role == "public":
            public.add((method, path))
        elif method == "WS":
            assert door.knock(path) == 401, path
            assert door.knock(path, "Authorization: Bearer nonsense") == 401, path
            assert door.knock(path, f"Cookie: {door.cookie_name}=nonsense") == 401, path
        else:
            assert door.ask(method, path).status == 401, (method, path)
            assert door.ask(method, path, token="nonsense").status == 401, (method, path)
    assert public == PUBLIC | PUBLIC_OF[type(door).__name__]


@pytest.mark.parametrize("method", ["GET", "POST", "PUT", "DELETE", "PATCH", "OPTIONS", "HEAD"])
def test_a_stranger_does_not_learn_what_exists(live: Live, method: str) -> None:
    assert live.ask(method, "/nowhere").status == 401
    assert live.ask(method, "/api/commands").status == 401


def test_a_foreign_host_is_refused_everywhere_whatever_it_shows(door: Served) -> None:
    for method, path, _ in ways_in(door.app):
        for host in ("evil.example", f"evil.example:{door.port}", "127.0.0.1.evil.example", "0.0.0.0", "[::2]:80"):
            if method == "WS":
                status = door.knock(path, f"Authorization: Bearer {door.operator}", host=host)
            else:
                status = door.ask(method, path, token=door.operator, host=host).status
            assert status == 403, (method, path, host)


@pytest.mark.parametrize("host", ["localhost", "LOCALHOST:80", "127.0.0.1", "[::1]:8420", "127.0.0.1:99999"])
def test_a_host_that_is_this_machine_is_answered(live: Live, host: str) -> None:
    assert live.ask("GET", "/api/me", token=live.operator, host=host).status == 200


@pytest.mark.parametrize(
    "head",
    [
        "GET /api/health HTTP/1.1\r\n\r\n",
        "GET /api/health HTTP/1.1\r\nHost: \r\n\r\n",
        "GET /api/health HTTP/1.0\r\n\r\n",
        "GET /api/health HTTP/1.1\r\nHost: 127.0.0.1\r\nHost: evil.example\r\n\r\n",
        "GET /api/health HTTP/1.1\r\nHost: 127.0.0.1, evil.example\r\n\r\n",
        "GET /api/health HTTP/1.1\r\nHost: user@127.0.0.1\r\n\r\n",
        "GET /api/health HTTP/1.1\r\nHost: 127.0.0.1/evil\r\n\r\n",
        "GET /api/health HTTP/1.1\r\nHost: 127.0.0.1:port\r\n\r\n",
        "GET /api/health HTTP/1.1\r\nHost: 127.0.0.1\u00e9\r\n\r\n",
    ],
)
def test_a_strange_host_header_is_malformed(live: Live, head: str) -> None:
    assert live.speak(head.replace("\r\n\r\n", "\r\nConnection: close\r\n\r\n").encode("latin-1"))[9:12] == b"400"


FOREIGN = [
    "http://evil.example",
    "null",
    "https://127.0.0.1:{port}",
    "http://127.0.0.1:1",
    "http://localhost:{port}",
    "http://127.0.0.1:{port}.evil.example",
    "http://127.0.0.1:{port}/",
    "",
    "file://",
]


@pytest.mark.parametrize("origin", FOREIGN)
def test_a_foreign_origin_may_change_nothing_and_open_no_socket(door: Served, origin: str) -> None:
    origin = origin.format(port=door.port)
    for method, path, _ in ways_in(door.app):
        if method == "WS":
            assert door.knock(path, f"Authorization: Bearer {door.operator}", f"Origin: {origin}") == 403, path
        elif method not in ("GET", "HEAD"):
            answer = door.ask(method, path, token=door.operator, headers={**BODYLESS, "Origin": origin})
            assert answer.status == 403, (method, path)


def signed_in(live: Live, token: str) -> str:
    answer = live.ask("POST", "/api/login", {"token": token}, headers={"Origin": f"http://127.0.0.1:{live.port}"})
    assert answer.status == 200
    return answer.headers["set-cookie"]


def test_the_cookie_is_out_of_reach_of_scripts_and_other_sites(live: Live) -> None:
    cookie = signed_in(live, live.operator)
    assert cookie.startswith(f"beckon_{live.port}=")
    assert {"HttpOnly", "SameSite=strict", "Path=/"} <= set(cookie.split("; "))
    assert live.operator not in cookie


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({"Origin": "own"}, 200),
        ({"Sec-Fetch-Site": "same-origin"}, 200),
        ({"Origin": "own", "Sec-Fetch-Site": "same-origin"}, 200),
        ({}, 403),
        ({"Sec-Fetch-Site": "same-site"}, 403),
        ({"Sec-Fetch-Site": "cross-site"}, 403),
        ({"Sec-Fetch-Site": "none"}, 403),
        ({"Origin": "own", "Sec-Fetch-Site": "cross-site"}, 403),
        ({"Origin": "null"}, 403),
        ({"Origin": "http://evil.example", "Sec-Fetch-Site": "same-origin"}, 403),
        ({"Referer": "own"}, 403),
    ],
    ids=str,
)
def test_a_cookie_alone_changes_nothing(live: Live, headers: dict[str, str], status: int) -> None:
    cookie = signed_in(live, live.operator).partition(";")[0]
    own = f"http://127.0.0.1:{live.port}"
    told = {name: own if value == "own" else value for name, value in headers.items()}
    assert live.ask("POST", "/api/stop", headers={**BODYLESS, "Cookie": cookie, **told}).status == status
    if "Origin" in told or status == 403:
        upgraded = live.knock("/ws", f"Cookie: {cookie}", *(f"{name}: {value}" for name, value in told.items()))
        assert upgraded == (101 if status == 200 else 403)


def test_a_get_by_cookie_needs_no_origin(live: Live) -> None:
    cookie = signed_in(live, live.viewer).partition(";")[0]
    assert live.ask("GET", "/api/me", headers={"Cookie": f"other=1; {cookie}"}).json["role"] == "viewer"


def test_what_a_role_may_is_what_is_declared(door: Served) -> None:
    for method, path, role in ways_in(door.app):
        if role in {"operator", "admin"}:
            below = {"operator": door.viewer, "admin": door.operator}[role]
            answer = door.ask(method, path, token=below, headers=BODYLESS)
            assert answer.status == 403, (method, path)
            assert role in answer.json["detail"]
        elif role == "viewer" and method == "GET":
            assert door.ask(method, path, token=door.viewer).status in (200, 404, 422), path


def test_a_viewer_stops_and_does_not_drive(live: Live) -> None:
    assert live.ask("POST", "/api/stop", token=live.viewer, headers=BODYLESS).status == 200
    assert live.ask("POST", "/api/commands", {"text": "stop moving"}, token=live.viewer).status == 202
    assert live.ask("POST", "/api/commands", {"text": "turn left"}, token=live.viewer).status == 403
    assert live.runtime.lease.holder is None


@pytest.mark.parametrize("end", ["sign out", "expire"])
def test_the_end_of_a_login_closes_its_sockets_and_frees_its_lease(
    live: Live, end: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    cookie = signed_in(live, live.operator).partition(";")[0]
    own = {"Cookie": cookie, "Origin": f"http://127.0.0.1:{live.port}"}
    me = live.ask("GET", "/api/me", headers=own).json["id"]
    with (
        open_as(live, own, "/ws") as line,
        open_as(live, own, "/scene/ws/tab", [SUBPROTOCOL]) as scene,
        live.open() as other,
    ):
        say(line, kind="lease", do="acquire", ref=1)
        hear(other, "state", true=lambda told: told["lease"]["holder_id"] == me)
        began = time.monotonic()
        if end == "sign out":
            assert live.ask("POST", "/api/logout", headers={**BODYLESS, **own}).status == 200
        else:
            logins, token = live.runtime.access.logins, cookie.partition("=")[2]
            digest = fingerprint(token)
            over = msgspec.structs.replace(logins._records.logins[digest], end_s=began)
            live.on_loop(lambda: logins._records.logins.update({digest: over}))
        assert ending(line)[0] == 1008
        assert ending(scene)[0] == 1008
        hear(other, "state", true=lambda told: told["lease"]["holder"] is None)
        assert time.monotonic() - began < 10.0  # as on a computer that does much else
    assert live.ask("GET", "/api/me", headers={"Cookie": cookie}).status == 401
    assert live.knock("/ws", *(f"{name}: {value}" for name, value in own.items())) == 401


def open_as(
    live: Live, headers: dict[str, str], path: str, subprotocols: list[str] | None = None
) -> ClientConnection:
    options = {"compression": None, "max_size": None, "proxy": None, "subprotocols": subprotocols}
    return connect(f"ws://127.0.0.1:{live.port}{path}", additional_headers=headers, **options)


def ending(line: ClientConnection) -> tuple[int, str]:
    """Read until the console closes → its code and reason."""
    with pytest.raises(ConnectionClosed) as closed:
        while True:
            line.recv(timeout=5)
    assert closed.value.rcvd is not None
    return closed.value.rcvd.code, closed.value.rcvd.reason


def test_a_second_tab_is_the_same_person_and_locks_nobody_out(live: Live) -> None:
    cookie = signed_in(live, live.operator).partition(";")[0]
    own = {"Cookie": cookie, "Origin": f"http://127.0.0.1:{live.port}"}
    me = live.ask("GET", "/api/me", headers=own).json
    again = live.ask("POST", "/api/login", {"token": live.operator}, headers=own)
    assert again.json == me
    assert again.headers["set-cookie"].partition(";")[0] == cookie
    assert live.ask("POST", "/api/lease", {"do": "acquire"}, headers=own).status == 200
    assert live.ask("POST", "/api/lease", {"do": "release"}, headers=own).status == 200


def test_the_sixth_wrong_token_within_a_minute_is_not_even_looked_at(live: Live) -> None:
    live.runtime.access.logins._wrong.clear()
    statuses = [live.ask("POST", "/api/login", {"token": "wrong"}).status for _ in range(6)]
    assert statuses == [401] * 5 + [429]
    elsewhere = {"X-Forwarded-For": "203.0.113.9"}  # as anybody on this machine may say
    assert live.ask("POST", "/api/login", {"token": "wrong"}, headers=elsewhere).status == 429
    assert live.ask("POST", "/api/login", {"token": live.viewer}).status == 200, "nobody locks the right key out"
    live.runtime.access.logins._wrong.clear()


@pytest.mark.parametrize(
    "name",
    [
        "operator",
        "Operator 3",
        "ｏｐｅｒａｔｏｒ",
        "viewer (2)",
        "admin",
        "\u202eresu",
        "a\u200bb",
        "\u3164",
        "x" * 41,
    ],
    ids=ascii,
)
def test_nobody_is_called_what_could_be_taken_for_someone_else(live: Live, name: str) -> None:
    assert live.ask("POST", "/api/login", {"token": live.viewer, "name": name}).status == 422


def test_people_are_called_as_they_say(live: Live) -> None:
    for name, called in ((" Zoë  M. ", "Zoë M."), ("操作员", "操作员")):
        assert live.ask("POST", "/api/login", {"token": live.viewer, "name": name}).json["name"] == called
    assert live.ask("POST", "/api/login", {"token": live.viewer, "name": " "}).json["name"].startswith("viewer ")


def test_who_shows_a_key_each_time_has_nothing_to_sign_out(live: Live) -> None:
    with live.open() as line:
        hear(line, "hello")
        answer = live.ask("POST", "/api/logout", token=live.operator, headers=BODYLESS)
        assert answer.status == 409 and "key" in answer.json["detail"]
        say(line, kind="echo", t=1)
        hear(line, "echo")


@pytest.mark.parametrize(("told", "status"), [("https", 200), ("http", 403), ("ftp", 403)])
def test_who_speaks_tls_for_the_console_says_so(live: Live, told: str, status: int) -> None:
    headers = {"Origin": f"https://127.0.0.1:{live.port}", "X-Forwarded-Proto": told}
    answer = live.ask("POST", "/api/login", {"token": live.viewer}, headers=headers)
    assert answer.status == status
    assert status != 200 or "Secure" in answer.headers["set-cookie"]


@pytest.mark.parametrize(
    "shown", ["", "Bearer", "Bearer ", "Basic eDp4", "Bearer \xe9\xff", "bearer  x", "Bearer a b"]
)
def test_strange_credentials_are_no_credentials(live: Live, shown: str) -> None:
    assert live.ask("GET", "/api/me", headers={"Authorization": shown}).status == 401


def test_two_credentials_are_malformed(live: Live) -> None:
    bearer = f"Authorization: Bearer {live.operator}\r\n"
    head = f"GET /api/me HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n{bearer}{bearer}\r\n"
    assert live.speak(head.encode())[9:12] == b"400"


def test_without_login_host_and_origin_still_count(open_live: Live) -> None:
    own = f"http://127.0.0.1:{open_live.port}"
    assert open_live.ask("GET", "/api/me").json["role"] == "admin"
    assert open_live.ask("POST", "/api/stop", headers=BODYLESS).status == 200
    assert open_live.ask("POST", "/api/stop", headers={**BODYLESS, "Origin": own}).status == 200
    assert open_live.ask("POST", "/api/stop", headers={**BODYLESS, "Origin": "http://evil.example"}).status == 403
    assert open_live.ask("POST", "/api/stop", headers={**BODYLESS, "Sec-Fetch-Site": "cross-site"}).status == 403
    assert open_live.ask("GET", "/api/me", host="evil.example").status == 403
    assert open_live.knock("/ws", "Origin: http://evil.example") == 403
    assert open_live.knock("/ws", f"Origin: {own}") == 101


def test_every_answer_wears_the_security_headers(live: Live) -> None:
    answers = [
        live.ask("GET", "/"),
        live.ask("GET", "/api/health"),
        live.ask("GET", "/api/me"),
        live.ask("GET", "/nowhere", token=live.operator),
        live.ask("GET", "/scene/", token=live.operator),
        live.ask("GET", "/api/me", host="evil.example"),
    ]
    for answer in answers:
        assert {name.decode() for name in HEADERS} <= set(answer.headers)
    assert "server" not in answers[0].headers
    assert "'unsafe-inline'" not in answers[0].headers["content-security-policy"]
    assert "unsafe-eval" in answers[4].headers["content-security-policy"]


def test_a_route_that_forgot_its_role_keeps_the_console_from_starting() -> None:
    app = FastAPI(openapi_url=None, docs_url=None, redoc_url=None)

    @app.get("/known")
    @needs("viewer")
    async def known() -> None: ...

    check_roles(app.routes)

    @app.websocket("/forgotten")
    async def forgotten() -> None: ...

    with pytest.raises(RuntimeError, match="/forgotten"):
        check_roles(app.routes)


def test_there_is_no_role_but_the_four() -> None:
    with pytest.raises(ValueError, match="no role"):
        needs("guest")
