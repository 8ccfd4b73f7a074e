"""What strangers and viewers may do to the console: little, and never for long."""

import asyncio
import contextlib
import gc
import http.client
import itertools
import json
import logging
import socket
import subprocess
import sys
import time
import weakref
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosed

from console.access import guard
from console.access.roles import JSON, KEY
from console.api.documentation import ADDRESS
from console.api.page import scene_page_file
from console.api.state_socket import MAX_STOP_MESSAGE, MOST_BYTES
from console.http.connection_limits import MOST_STRANGERS, ConnectionLimits, network_of
from console.http.incremental_parsing import PIECE_BYTES, IncrementalProtocol
from console.http.timeouts import MOST_PINGS, SHORT_BODY_BYTES, TimeoutHttp
from console.logging_setup import MOST_ALIKE, RepeatFilter
from tests.benchmarks.loop_share import watched
from tests.console.live import MORE, Live, hear, say, say_at_once
from tests.console.test_tls import certificate, openssl

HALF = b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n"


def chunked(body: bytes) -> bytes:
    """A body in the smallest pieces there are."""
    return b"".join(b"1\r\n" + bytes([byte]) + b"\r\n" for byte in body) + b"0\r\n\r\n"


def head(live: Live, path: str, *more: str, key: str | None = None) -> bytes:
    lines = [f"POST {path} HTTP/1.1", "Host: 127.0.0.1", "Content-Type: application/json", *more]
    lines += [f"Authorization: Bearer {key}"] if key else []
    return ("\r\n".join(lines) + "\r\n\r\n").encode()


# bodies


@pytest.mark.parametrize("size", [KEY.most + 1, 1_000_000])
def test_a_stranger_may_send_a_key_and_no_more(live: Live, size: int) -> None:
    body = b"[" + b"1," * (size // 2) + b"1]"
    assert live.ask("POST", "/api/login", raw=body).status == 413
    unending = head(live, "/api/login", "Transfer-Encoding: chunked", "Connection: close")
    assert live.speak(unending + chunked(body[:5000]))[9:12] == b"413"


def test_json_is_bounded_unless_a_way_in_asks_for_more(live: Live) -> None:
    long = {"text": "x" * JSON.most}
    assert live.ask("POST", "/api/commands", long, token=live.operator).status == 413
    assert live.ask("POST", "/api/sim/say", {"pcm": "A" * 2 * JSON.most}, token=live.operator).status != 413


def test_long_json_is_not_read_on_the_event_loop(live: Live, monkeypatch: pytest.MonkeyPatch) -> None:
    import threading

    readers: list[str] = []
    read = guard.read_json

    def noted(raw: bytes) -> Any:
        readers.append(threading.current_thread().name)
        return read(raw)

    monkeypatch.setattr(guard, "read_json", noted)
    live.ask("POST", "/api/commands", {"text": "stop"}, token=live.operator)
    live.ask("POST", "/api/commands", {"text": "x" * 40_000}, token=live.operator)
    assert readers[0] != readers[1]


# pieces


class Parser(IncrementalProtocol):
    """A protocol that notes what it is given."""

    def __init__(self) -> None:
        super().__init__(set())
        self.loop = asyncio.get_running_loop()
        self.pieces: list[bytes] = []
        self.reads: list[str] = []
        self.is_full = False
        self.transport = SimpleNamespace(  # type: ignore[assignment]
            pause_reading=lambda: self.reads.append("pause"),
            resume_reading=lambda: self.reads.append("resume"),
            is_closing=lambda: False,
        )

    @property
    def full(self) -> bool:
        return self.is_full

    def take(self, piece: bytes) -> None:
        time.sleep(0.0006)
        self.pieces.append(piece)


def test_what_arrives_in_one_blow_lets_everything_else_have_its_turn() -> None:
    async def story() -> None:
        parser, turns, given = Parser(), 0, bytes(range(256)) * 40 + b"end"
        parser.arrived(given)
        assert len(parser.pieces) < 9 and parser.reads == ["pause"]
        while parser.reads[-1] != "resume":
            turns += 1
            await asyncio.sleep(0)
        assert turns >= len(given) / PIECE_BYTES / 3
        assert b"".join(parser.pieces) == given and max(map(len, parser.pieces)) <= PIECE_BYTES

    asyncio.run(story())


def test_a_parser_that_is_full_is_given_nothing_until_it_is_not() -> None:
    async def story() -> None:
        parser = Parser()
        parser.is_full = True
        parser.arrived(b"x" * 10)
        await asyncio.sleep(0.01)
        assert parser.pieces == [] and parser.reads == ["pause"]
        parser.is_full = False
        parser.go_on_soon()
        await asyncio.sleep(0.01)
        assert parser.pieces == [b"x" * 10] and parser.reads[-1] == "resume"

    asyncio.run(story())


def test_a_body_in_the_smallest_pieces_arrives_whole(live: Live) -> None:
    body = json.dumps({"text": " " * 1500 + "stop moving"}).encode()
    told = head(live, "/api/commands", "Transfer-Encoding: chunked", "Connection: close", key=live.operator)
    assert live.speak(told + chunked(body))[9:12] == b"202"


def test_many_requests_in_one_blow_are_answered_each(live: Live) -> None:
    ask = b"GET /api/me HTTP/1.1\r\nHost: 127.0.0.1\r\nAuthorization: Bearer " + live.operator.encode() + b"\r\n"
    with socket.create_connection(("127.0.0.1", live.port), timeout=10) as line:
        line.sendall((ask + b"\r\n") * 99 + ask + b"Connection: close\r\n\r\n")
        heard = b"".join(iter(lambda: line.recv(65536), b""))
    assert heard.count(b"HTTP/1.1 200") == 100


def test_many_messages_in_one_blow_are_all_taken(live: Live) -> None:
    with live.open() as line:
        hear(line, "hello")
        texts = [json.dumps({"kind": "echo", "t": 100 + n}).encode() for n in range(150)]
        frames = [bytes([0x81, 0x80 | len(text)]) + bytes(4) + text for text in texts]
        line.socket.sendall(b"\x8a\x80\0\0\0\0" * 5000 + b"".join(frames))  # empty pongs first
        assert [hear(line, "echo")["t"] for _ in range(150)] == [100 + n for n in range(150)]


def test_a_socket_that_pings_without_end_is_closed(live: Live) -> None:
    with live.open() as line:
        hear(line, "hello")
        line.socket.sendall(b"\x89\x80\0\0\0\0" * (MOST_PINGS + 1))
        with pytest.raises(ConnectionClosed):
            while True:
                line.recv(timeout=5)


def status(line: socket.socket) -> int:
    """The next answer on a connection."""
    answer = http.client.HTTPResponse(line)
    answer.begin()
    answer.read()
    return answer.status


@pytest.mark.parametrize("size", [100, SHORT_BODY_BYTES + 1])
def test_a_body_that_is_answered_early_is_read_while_that_is_worth_it(live: Live, size: int) -> None:
    """A program that sends its next request on the same connection finds it open after a short one."""
    with socket.create_connection(("127.0.0.1", live.port), timeout=5) as line:
        line.sendall(head(live, "/api/commands", f"Content-Length: {size}"))
        assert status(line) == 401
        with contextlib.suppress(ConnectionError, http.client.HTTPException):
            line.sendall(b"x" * size + b"GET /api/health HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
            assert status(line) == 200 and size <= SHORT_BODY_BYTES
            return
        assert size > SHORT_BODY_BYTES


def test_no_blow_keeps_the_event_loop(live: Live) -> None:
    """In processor time, which does not depend on what else the machine does."""
    blows = [
        head(live, "/api/login", "Transfer-Encoding: chunked") + b"1\r\n1\r\n" * 40_000,
        head(live, "/api/login", "Content-Length: 998003") + b"[" + b"1," * 499_000 + b"1]",
        b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n" + b"a:\r\n" * 60_000,
    ]
    assert live._thread.ident is not None
    with watched(live._thread.ident) as share:
        for blow in blows:
            with contextlib.suppress(ConnectionError):
                live.speak(blow, wait=0.3)
    assert 0.0 < share.worst < 0.02


# a socket's budget


def test_a_flood_of_bytes_ends_the_socket_and_a_stop_in_it_is_heard(live: Live) -> None:
    text = json.dumps({"kind": "echo", "t": 1, "x": "\N{EURO SIGN}" * 3_300}, ensure_ascii=False)  # 3 bytes each
    newest = max((entry.id for entry in live.runtime.history.newest_first(commands_only=False)), default=0)
    with live.open(token=live.viewer) as line:
        hear(line, "hello")
        second = [text] * (MOST_BYTES // 10_000 + 1)  # of a busy machine's several, one has more than a second may
        say_at_once(line, [*second, json.dumps({"kind": "stop"}), *9 * second])
        began = time.monotonic()
        with pytest.raises(ConnectionClosed) as closed:
            while time.monotonic() < began + MORE:
                line.recv(timeout=5)
    assert closed.value.rcvd is not None
    assert closed.value.rcvd.code == 1008 and "bytes" in closed.value.rcvd.reason
    assert live.runtime.history.newest_first(commands_only=False)[0].id > newest
    assert len('{"kind":"stop","press":9007199254740992}') < MAX_STOP_MESSAGE


def test_a_sentence_of_the_longest_kind_fits_into_a_message(live: Live) -> None:
    with live.open() as line:
        say(line, kind="command", text="\u4e00" * 2000, source="typed", ref=1)  # 6 bytes each, escaped
        assert hear(line, "answer")["status"] == 422


# places


class Held:
    """A connection that someone holds."""

    def __init__(self, *, stranger: bool = True, idle: bool = True) -> None:
        self.stranger, self.idle, self.dropped, self.silence_s = stranger, idle, False, 0.0

    def drop(self, silence_s: float = 0.0) -> None:
        self.dropped, self.silence_s = True, silence_s


def test_the_eldest_stranger_of_an_address_makes_room_for_the_next() -> None:
    crowd = ConnectionLimits()
    driver = Held(stranger=False)
    crowd.enter(driver, "10.0.0.1")
    strangers = [Held() for _ in range(MOST_STRANGERS)]
    for one in strangers:
        crowd.enter(one, "10.0.0.1")
    crowd.enter(elsewhere := Held(), "10.0.0.2")
    assert not any(one.dropped for one in (*strangers, driver, elsewhere))
    crowd.enter(newest := Held(), "10.0.0.1")
    assert strangers[0].dropped and not strangers[1].dropped and not newest.dropped and not driver.dropped


def test_who_is_dropped_hears_of_it_later_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "console.http.connection_limits.time", SimpleNamespace(monotonic=lambda: 100.0)
    )  # however busy
    crowd = ConnectionLimits(40)
    strangers = [Held() for _ in range(200)]
    for one in strangers:
        crowd.enter(one, "10.0.0.1")
    silences = [one.silence_s for one in strangers if one.dropped]
    assert len(silences) == 160
    later, at_once = silences[:80], silences[80:]
    assert min(later) >= 0.9 and all(b > a for a, b in itertools.pairwise(later)) and later[-1] > 1.15
    assert not any(at_once), "no more descriptors are kept for them"


def test_where_all_places_are_taken_strangers_go_first_then_who_asks_nothing() -> None:
    crowd = ConnectionLimits(4)
    driver, watcher = Held(stranger=False, idle=False), Held(stranger=False)
    for one in (driver, watcher, few := Held()):
        crowd.enter(one, "10.0.0.1")
    crowd.enter(alone := Held(), "10.0.0.2")
    crowd.enter(newest := Held(), "10.0.0.3")
    assert few.dropped and not (driver.dropped or watcher.dropped or alone.dropped or newest.dropped)
    crowd.leave(few, "10.0.0.1")  # that it has ended is heard after its place was given away
    assert len(crowd) == 4
    others = [Held(stranger=False, idle=False) for _ in range(4)]
    for one in others[:3]:
        crowd.enter(one, "10.0.1.1")
    assert alone.dropped and newest.dropped and watcher.dropped and not driver.dropped
    crowd.enter(others[3], "10.0.1.1")
    assert others[3].dropped and not driver.dropped and not any(one.dropped for one in others[:3])
    assert len(crowd) == 4


def test_one_home_counts_as_one_address() -> None:
    assert network_of("2001:db8:1:2::1") == network_of("2001:db8:1:2:ffff::9") != network_of("2001:db8:1:3::1")
    assert network_of("fe80::1%eth0") == network_of("fe80::2%eth0")
    assert network_of("10.0.0.1") != network_of("10.0.0.2")


@contextlib.contextmanager
def half_open(live: Live, number: int) -> Iterator[None]:
    """Requests that are never completed."""
    with contextlib.ExitStack() as stack:
        for _ in range(number):
            line = stack.enter_context(socket.create_connection(("127.0.0.1", live.port), timeout=5))
            line.sendall(HALF)
        yield


def test_half_requests_take_their_own_places_and_no_more(live: Live) -> None:
    with live.open() as line, half_open(live, 2 * MOST_STRANGERS):
        live.until(lambda: len(live.server.config.crowd) <= MOST_STRANGERS + 2)
        assert live.ask("POST", "/api/stop", token=live.operator, headers={"Content-Length": "0"}).status == 200
        say(line, kind="echo", t=5)
        hear(line, "echo")
    live.until(lambda: len(live.server.config.crowd) == 0)


def test_a_connection_that_is_over_leaves_nothing_to_the_collector_of_garbage(live: Live) -> None:
    def held() -> list[weakref.ref[Any]]:
        return [weakref.ref(one) for one in live.server.server_state.connections]

    gc.collect()
    gc.disable()
    try:
        with half_open(live, 5), live.open():
            live.until(lambda: len(live.on_loop(held)) >= 6)
            kept = live.on_loop(held)
            kinds = {type(one()).__name__ for one in kept}
            transports = [weakref.ref(one().transport) for one in kept]
        assert kinds == {"TimeoutHttp", "TimeoutSocket"}
        live.until(lambda: not any(one() for one in (*kept, *transports)))
    finally:
        gc.enable()


def test_every_answer_is_sent_at_once(live: Live) -> None:
    def delays() -> set[int]:
        lines = [one for one in live.server.server_state.connections if isinstance(one, TimeoutHttp)]
        taken = [one.transport.get_extra_info("socket") for one in lines]
        return {raw.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY) for raw in taken}

    with half_open(live, 1):
        assert live.until(lambda: live.on_loop(delays)) == {1}


def test_as_many_files_are_asked_for_as_there_may_be() -> None:
    code = (
        "import resource; from console.http.connection_limits import MAX_CONNECTIONS, raise_file_limit;"
        "print(raise_file_limit(), *resource.getrlimit(resource.RLIMIT_NOFILE))"
    )

    def most(soft: int, hard: int) -> list[int]:
        limited = f"import resource; resource.setrlimit(resource.RLIMIT_NOFILE, ({soft}, {hard})); {code}"
        told = subprocess.run([sys.executable, "-c", limited], capture_output=True, text=True, check=True)
        return [int(word) for word in told.stdout.split()]

    assert most(256, 1024) == [256, 1024, 1024]
    assert most(256, 4096) == [600, 4096, 4096]


@openssl
def test_who_does_not_even_begin_tls_is_let_go(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("console.http.server.HEADER_TIME_S", 0.3)
    with (
        Live(tmp_path / "home", tls=certificate(tmp_path)) as live,
        socket.create_connection(("127.0.0.1", live.port), timeout=15) as line,
        contextlib.suppress(ConnectionResetError),
    ):
        assert line.recv(100) == b""


# the description, the log


def test_the_scenes_page_is_packed_before_anybody_asks(live: Live) -> None:
    live.until(lambda: scene_page_file.cache_info().currsize == 1)


def test_the_description_is_written_before_anybody_asks(live: Live) -> None:
    written = live.until(lambda: live.app.state.description._written)
    live.until(written.done)
    told = live.ask("GET", "/openapi.json", token=live.viewer).body.decode()
    assert told == written.result().replace(ADDRESS, f"http://127.0.0.1:{live.port}")


def test_sockets_of_strangers_leave_no_line_in_the_log(live: Live, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        assert [live.knock("/ws") for _ in range(3)] == [401] * 3
        assert live.knock("/ws", host="evil.example") == 403
    assert caplog.records == []


def test_what_strangers_provoke_does_not_push_the_rest_out_of_the_log(monkeypatch: pytest.MonkeyPatch) -> None:
    now, said = [0.0], list[str]()
    monkeypatch.setattr("console.logging_setup.time", SimpleNamespace(monotonic=lambda: now[0]))
    few = RepeatFilter(said.append)

    def line(words: str, *given: object) -> bool:
        return bool(few.filter(logging.LogRecord("x", logging.ERROR, "", 0, words, given, None)))

    assert [line("accept failed\nsocket %d", n) for n in range(MOST_ALIKE + 30)].count(True) == MOST_ALIKE
    assert line("another fault")
    now[0] = 61.0
    assert line("accept failed\nsocket %d", 7)
    assert said == ["30 lines like “accept failed” were left out."]


@pytest.mark.parametrize(
    ("path", "body", "field"),
    [
        ("/api/places", {"name": "Gate", "x_m": 0, "y_m": 0}, "heading_rad"),
        ("/api/slam/here", {"x_m": 0, "y_m": 0, "force": True}, "heading_rad"),
        ("/api/robot/navigation/goal", {"x_m": 0, "y_m": 0}, "heading_rad"),
        ("/api/sim/place", {"what": "robot", "x_m": 0, "y_m": 0}, "heading_rad"),
        ("/api/commands", {"text": "come here"}, "towards_rad"),
        ("/api/calibration/microphones/clap", {}, "azimuth_rad"),
    ],
)
def test_an_angle_in_degrees_is_refused(live: Live, path: str, body: dict[str, object], field: str) -> None:
    told = live.ask("POST", path, {**body, field: 90}, token=live.operator)
    assert told.status == 422 and [one["wrong"] for one in told.json["errors"]] == ["less_than_equal"]
