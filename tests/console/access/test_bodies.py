"""Bodies that are malformed, hostile, endless or slow: a problem with a sentence, never a 500, never an echo."""

import socket
import time
from typing import Any

import psutil
import pytest
import schemathesis
from hypothesis import HealthCheck, given, settings

from console.access.roles import KEY
from tests.console.live import Live

TAKING = ["/api/commands", "/api/lease", "/api/login", "/api/playback", "/api/sim/place", "/api/sim/remove",
          "/api/maps", "/api/slam/here", "/api/people/0123456789ab/rename",
          "/api/calibration/sessions", "/api/calibration/in-use/undo", "/api/calibration/demo"]  # fmt: skip
MARK = "needle7e1f"

MALFORMED = {
    "nothing": b"",
    "a brace": b"{",
    "words": MARK.encode(),
    "NaN": b'{"x_m": NaN}',
    "Infinity": b'{"x_m": Infinity}',
    "1e999": b'{"x_m": 1e999}',
    "a half character": b'{"text": "\\ud800"}',
    "a half character as key": b'{"\\udc00": 1}',
    "keys twice": b'{"text": "stop", "text": "turn left"}',
    "keys twice deep": b'{"a": {"text": 1, "text": 2}}',
    "UTF-16": '{"text": "turn left"}'.encode("utf-16"),
    "UTF-16 without mark": '{"text": "turn left"}'.encode("utf-16-le"),
    "Latin-1": b'{"text": "\xe9"}',
    "an encoded surrogate": b'{"text": "\xed\xa0\x80"}',
    "a byte order mark": b"\xef\xbb\xbf{}",
    "deep lists": b"[" * 60_000,
    "deep objects": b'{"a":' * 12_000,
    "an endless number": b'{"id": ' + b"9" * 60_000 + b"}",
    "a list": b"[]",
    "a text": f'"{MARK}"'.encode(),
    "a number": b"7",
    "null": b"null",
    "an unknown key": f'{{"{MARK}": "{MARK}"}}'.encode(),
    "true for a number": b'{"what": "box", "x_m": true, "y_m": 0}',
    "a text for a number": f'{{"what": "box", "x_m": "{MARK}", "y_m": 0}}'.encode(),
    "a number for a text": b'{"text": 5, "token": 5, "do": 5, "id": 5}',
    "null for a text": b'{"text": null, "token": null, "do": null, "id": null}',
    "a long text": b'{"text": "' + MARK.encode() * 5000 + b'"}',
    "an object for a text": b'{"text": {}, "token": [], "do": {}, "id": {}}',
    "a prototype": b'{"__proto__": {"text": "stop"}, "constructor": 1}',
    "a control character": b'{"text": "a\nb"}',
    "NUL": b"\x00" * 50,
    "a form": f"text={MARK}".encode(),
    "XML": f'<?xml version="1.0"?><!DOCTYPE x [<!ENTITY a "{MARK}">]><x>&a;</x>'.encode(),
}


@pytest.mark.parametrize("path", TAKING)
def test_a_malformed_body_is_refused_with_a_sentence_and_never_echoed(live: Live, path: str) -> None:
    for name, raw in MALFORMED.items():
        live.runtime.access.logins._wrong.clear()
        answer = live.ask("POST", path, raw=raw, token=live.operator)
        too_large = path == "/api/login" and len(raw) > KEY.most
        assert answer.status in ((413,) if too_large else (400, 415, 422)), (name, answer.status)
        assert answer.headers["content-type"] == "application/problem+json", name
        told = answer.json
        assert told["status"] == answer.status and told["detail"].endswith((".", "?")), name
        assert MARK not in answer.body.decode(), name
        assert len(answer.body) < 2000, name
    live.runtime.access.logins._wrong.clear()


@pytest.mark.parametrize(
    ("kind", "more"),
    [
        ("text/plain", {}),
        ("application/x-www-form-urlencoded", {}),
        ("multipart/form-data; boundary=x", {}),
        ("application/json; charset=utf-16", {}),
        ("application/jsonp", {}),
        ("", {}),
        ("application/json", {"Content-Encoding": "gzip"}),
        ("application/json", {"Content-Encoding": "identity"}),
    ],
)
def test_only_plain_json_is_read(live: Live, kind: str, more: dict[str, str]) -> None:
    headers = {"Content-Type": kind, **more}
    answer = live.ask("POST", "/api/commands", raw=b'{"text": "stop"}', token=live.operator, headers=headers)
    assert answer.status == 415


@pytest.mark.parametrize("kind", ["application/json", "APPLICATION/JSON", 'application/json; charset="utf-8"'])
def test_json_may_be_declared_as_people_do(live: Live, kind: str) -> None:
    headers = {"Content-Type": kind}
    answer = live.ask("POST", "/api/commands", raw=b'{"text": "stop"}', token=live.operator, headers=headers)
    assert answer.status == 202


def head(live: Live, path: str, *more: str) -> bytes:
    lines = [
        f"POST {path} HTTP/1.1",
        "Host: 127.0.0.1",
        f"Authorization: Bearer {live.operator}",
        "Content-Type: application/json",
        *more,
    ]
    return ("\r\n".join(lines) + "\r\n\r\n").encode()


def memory() -> float:
    """What this process holds [MB]."""
    return psutil.Process().memory_info().rss / 1e6


def test_a_body_that_says_it_is_huge_is_not_waited_for(live: Live) -> None:
    heard = live.speak(head(live, "/api/commands", "Content-Length: 5000000000"), wait=3)
    assert heard[9:12] == b"413"


def test_a_body_that_never_ends_is_cut_off_and_not_kept(live: Live) -> None:
    with socket.create_connection(("127.0.0.1", live.port), timeout=5) as line:
        line.sendall(head(live, "/api/commands", "Transfer-Encoding: chunked"))
        part = b"10000\r\n" + b" " * 65536 + b"\r\n"
        before, began = memory(), time.monotonic()
        with pytest.raises(OSError):
            while time.monotonic() - began < 10:
                line.sendall(part)
        assert memory() - before < 30
    assert live.ask("GET", "/api/health").status == 200


def test_a_body_that_trickles_is_given_up(live: Live, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("console.access.guard.BODY_TIME_S", 0.4)
    with socket.create_connection(("127.0.0.1", live.port), timeout=5) as line:
        line.sendall(head(live, "/api/commands", "Content-Length: 100") + b"{")
        time.sleep(0.2)
        line.sendall(b" ")
        assert line.recv(100)[9:12] == b"408"


def test_a_head_that_never_ends_is_given_up(live: Live, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("console.http.timeouts.HEADER_TIME_S", 0.4)
    with socket.create_connection(("127.0.0.1", live.port), timeout=5) as line:
        line.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n")
        with pytest.raises(OSError):
            for _ in range(100):
                line.sendall(b"X-More: 1\r\n")
                time.sleep(0.1)


@pytest.mark.parametrize(
    "raw",
    [
        b"\r\n\r\n",
        b"nonsense\r\n\r\n",
        b"GET / HTTP/9.9\r\n\r\n",
        b"GET /\x00 HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n",
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
        b"POST /api/stop HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: -1\r\n\r\n",
        b"POST /api/stop HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 1\r\nContent-Length: 2\r\n\r\n",
        b"POST /api/stop HTTP/1.1\r\nHost: 127.0.0.1\r\nTransfer-Encoding: gzip\r\n\r\n",
        b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX: " + b"x" * 2_000_000 + b"\r\n\r\n",
    ],
    ids=lambda raw: repr(raw[:30]),
)
def test_what_is_no_http_is_refused(live: Live, raw: bytes) -> None:
    try:
        heard = live.speak(raw, wait=0.5)
    except (BrokenPipeError, ConnectionResetError):
        return
    assert heard == b"" or heard[9:10] == b"4"


@pytest.mark.parametrize(
    ("method", "path", "status"),
    [
        ("GET", "/api/nothing", 404),
        ("DELETE", "/api/commands", 405),
        ("GET", "/api/stop", 405),
        ("GET", "/api/commands/12345", 404),
        ("GET", "/api/commands/abc", 422),
        ("GET", "/api/commands/" + "9" * 5000, 422),
        ("GET", "/api/commands/-1", 404),
        ("GET", "/static/../console/app.py", 404),
        ("GET", "/static/%2e%2e/pyproject.toml", 404),
        ("GET", "/static/..%2fpyproject.toml", 404),
        ("GET", "/static/%2fetc/passwd", 404),
        ("GET", "/static/js/\\..\\..\\pyproject.toml", 404),
        ("GET", "/static/%00", 404),
        ("GET", "/static/js", 404),
        ("GET", "/scene/../../etc/passwd", 404),
        ("GET", "//evil.example/", 404),
        ("POST", "/static/js/main.js", 405),
    ],
)
def test_wrong_turns_are_problems_too(live: Live, method: str, path: str, status: int) -> None:
    answer = live.ask(
        method, path, token=live.operator, headers={"Content-Length": "0"} if method == "POST" else None
    )
    assert answer.status == status
    assert answer.headers["content-type"] == "application/problem+json"
    if status == 405:
        assert answer.headers["allow"]


@pytest.mark.parametrize("every", [4, pytest.param(1, marks=pytest.mark.campaign)])
def test_the_interface_keeps_to_its_own_description(rough_live: Live, every: int) -> None:
    config = schemathesis.Config.from_dict(
        {
            "checks": {
                "positive_data_acceptance": {"expected-statuses": ["2xx", 401, 404, 409, 422, 429, 503]},
                "not_a_server_error": {"expected-statuses": ["2xx", "3xx", "4xx", 503]},
            }
        }
    )
    headers = {"Authorization": f"Bearer {rough_live.admin}"}
    address = f"http://127.0.0.1:{rough_live.port}/openapi.json"
    schema = schemathesis.openapi.from_url(address, headers=headers, config=config)
    operations = [found.ok() for found in schema.get_all_operations()]
    assert len(operations) > 15
    for operation in operations[::every]:

        @settings(
            max_examples=2, deadline=None, derandomize=True, database=None, suppress_health_check=list(HealthCheck)
        )
        @given(case=operation.as_strategy())
        def keeps_to_it(case: Any) -> None:
            case.call_and_validate(headers=headers, timeout=120)

        keeps_to_it()
