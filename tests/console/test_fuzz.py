"""Thousands of hostile messages: no 5xx, no exit, no unexplained end of a socket, flat memory."""

import http.client
import json
import random
from typing import Any

import psutil
import pytest
from websockets.exceptions import ConnectionClosed

from tests.console.live import Live

PATHS = [
    "/", "/docs", "/openapi.json", "/scene/", "/static/js/main.js", "/api/health", "/api/me", "/api/state",
    "/api/commands", "/api/commands/history", "/api/commands/1", "/api/audit", "/api/lease", "/api/login",
    "/api/logout", "/api/map", "/api/map.png", "/api/playback", "/api/sim/truth", "/api/sim/place",
    "/api/sim/remove", "/api/sim/plan", "/api/stop", "/api/halt", "/api/halt/reset", "/nowhere",
    "/api/calibration/sessions", "/api/calibration/sessions/1", "/api/calibration/sessions/1/live",
    "/api/calibration/sessions/1/pictures", "/api/calibration/sessions/1/views/1.jpg", "/api/calibration/board.svg",
    "/api/calibration/sessions/1/views/1/drop", "/api/calibration/sessions/1/accept", "/api/calibration/import",
    "/api/calibration/sessions/1/export/all", "/api/calibration/in-use", "/api/calibration/in-use/undo",
    "/api/calibration/demo", "/people", "/api/people", "/api/people/chosen", "/api/people/demo",
    "/api/people/1", "/api/people/1/background", "/api/people/1/pictures/1.jpg", "/api/people/1/capture",
    "/api/people/1/finish", "/api/people/1/rename", "/connect", "/api/robot/connection", "/api/robot/probe",
    "/api/robot/file",
]  # fmt: skip
METHODS = ["GET", "POST", "PUT", "DELETE", "PATCH", "OPTIONS", "HEAD", "TRACE", "BREW"]
KEYS = ["kind", "text", "do", "value", "ref", "v", "w", "press", "seq", "nonce", "epoch", "camera", "t", "x_m", "y_m",
        "calibration", "board", "on",
        "what", "id", "token", "name", "source", "size_m", "__proto__", "", "\u202e", "k" * 300]  # fmt: skip
WORDS = ["drive", "stop", "command", "lease", "halt", "halt_reset", "playback", "want", "echo", "acquire", "take",
         "release", "turn left", "continue 1 meters", "stop at 1 and 1", "typed", "click", "seek", "play", "box",
         "person", "robot", "../../etc/passwd", "<script>alert(1)</script>", "'; DROP TABLE deeds; --", "\x00",
         "é" * 50, "%s%n", "${jndi:x}", "{{7*7}}", "\u202e\ufeff", "\U0001f916"]  # fmt: skip
NUMBERS = [0, 1, -1, 0.5, -0.0, 1e308, -1e308, 5e-324, 2**31, 2**53, 2**63, -(2**63), 10**17, 1e-9, 3.14]
RAW = [
    b"NaN",
    b"Infinity",
    b"-Infinity",
    b"1e999",
    b'"\\ud800"',
    b"[[[[[[",
    b'{"a":1,"a":2}',
    b"\xff\xfe",
    b"\xef\xbb\xbf{}",
]
EXPLAINED = {1000, 1003, 1007, 1008, 1009, 1013}


def value(rng: random.Random, depth: int = 0) -> Any:
    kind = rng.randrange(9 if depth < 3 else 6)
    if kind == 0:
        return rng.choice([None, True, False])
    if kind in (1, 2):
        return rng.choice(NUMBERS)
    if kind in (3, 4, 5):
        return rng.choice(WORDS)
    if kind == 6:
        return [value(rng, depth + 1) for _ in range(rng.randrange(4))]
    return {rng.choice(KEYS): value(rng, depth + 1) for _ in range(rng.randrange(5))}


def likely(rng: random.Random) -> dict[str, Any]:
    """Nearly a message, or exactly one."""
    kind = rng.choice(["drive", "command", "lease", "halt_reset", "playback", "want", "echo", "stop"])
    forms: dict[str, list[str]] = {
        "drive": ["v", "w", "press", "seq", "nonce", "epoch"],
        "command": ["text", "source", "ref"],
        "lease": ["do", "ref"],
        "halt_reset": ["ref"],
        "playback": ["action", "t_s", "speed", "way", "ref"],
        "want": ["camera", "calibration"],
        "echo": ["t"],
        "stop": [],
    }
    return {"kind": kind, **{key: value(rng, 2) for key in forms[kind] if rng.random() < 0.95}}


def mangled(rng: random.Random, raw: bytes) -> bytes:
    """Some bytes changed, cut or doubled, now and then."""
    chance = rng.random()
    if chance < 0.1:
        return rng.choice(RAW)
    if chance < 0.2 and raw:
        at = rng.randrange(len(raw))
        return raw[:at] + bytes([rng.randrange(256)]) + raw[at + 1 :]
    if chance < 0.25:
        return raw[: rng.randrange(len(raw) + 1)]
    return raw


def fuzz_http(live: Live, rng: random.Random, times: int) -> None:
    line = http.client.HTTPConnection("127.0.0.1", live.port, timeout=20)
    for _ in range(times):
        method, path = (
            rng.choice(METHODS),
            rng.choice(PATHS) + rng.choice(["", "", "", "/", "?a=1&a=2", "?" + "x" * 500]),
        )
        raw = mangled(rng, json.dumps(value(rng)).encode())
        headers = {
            "Host": f"127.0.0.1:{live.port}",
            "Authorization": f"Bearer {rng.choice([live.operator, live.operator, live.viewer, 'wrong'])}",
            "Content-Type": rng.choice(["application/json"] * 8 + ["text/plain", "application/json; charset=utf-16"]),
        }
        body = raw if method in ("POST", "PUT", "PATCH", "DELETE") else None
        try:
            line.request(method, path, body, headers)
            answer = line.getresponse()
            told = answer.read()
        except (http.client.HTTPException, OSError):
            line.close()
            continue
        assert answer.status < 500 or answer.status == 503, (method, path, raw, told)
        if answer.status >= 400 and method != "HEAD":
            assert json.loads(told)["detail"], (method, path)
    line.close()


def fuzz_socket(live: Live, rng: random.Random, times: int) -> None:
    sent = 0
    while sent < times:
        with live.open(token=rng.choice([live.operator, live.viewer]), ping_interval=None) as line:
            try:
                for _ in range(rng.randrange(20, 150)):
                    message = likely(rng) if rng.random() < 0.7 else value(rng)
                    raw = json.dumps(message).encode()
                    raw = mangled(rng, raw) if rng.random() < 0.1 else raw
                    line.send(raw if rng.random() < 0.01 else raw.decode("utf-8", "replace"))
                    sent += 1
            except ConnectionClosed as end:
                assert end.rcvd is not None and end.rcvd.code in EXPLAINED, end


def campaign(live: Live, seed: int, messages: int) -> None:
    rng = random.Random(seed)
    for _ in range(messages // 100):
        fuzz_http(live, rng, 20)
        fuzz_socket(live, rng, 80)
        live.runtime.access.logins._wrong.clear()
    live.until(lambda: len(live.runtime.sockets) == 0)
    assert live.ask("GET", "/api/health").status == 200
    live.calm()


def memory() -> float:
    return psutil.Process().memory_info().rss / 1e6


def test_a_thousand_hostile_messages_break_nothing(rough_live: Live) -> None:
    campaign(rough_live, 1, 1000)


@pytest.mark.campaign
def test_sixty_thousand_hostile_messages_break_nothing_and_leave_nothing(rough_live: Live) -> None:
    campaign(rough_live, 2, 10_000)
    before = memory()
    campaign(rough_live, 3, 50_000)
    assert memory() - before < 25
