"""The socket: newest state and picture down, hands and words up, and an end that always has a reason."""

import json
import socket
import struct
import threading
import time
from unittest.mock import Mock

import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection

from console.api.state_socket import FLOOD, MOST_PER_SECOND
from console.control.stop import MAX_RECORDED_STOPS
from console.http.timeouts import TimeoutSocket
from tests.console.live import Live, hear, say, say_at_once

TOO_MANY = ['{"kind":"echo","t":1}'] * (5 * MOST_PER_SECOND)  # also for a console that had stood for a while


def closed(line: ClientConnection, seconds: float = 10.0) -> tuple[int, str]:
    """Read until the other side closes → its code and reason."""
    end = time.monotonic() + seconds
    with pytest.raises(ConnectionClosed) as end_of_it:
        while time.monotonic() < end:
            line.recv(timeout=seconds)
    frame = end_of_it.value.rcvd
    assert frame is not None, "no close code came"
    return frame.code, frame.reason


def drive(line: ClientConnection, state: dict, v: float, w: float = 0.0, *, press: int, seq: int) -> None:
    gate = state["gate"]
    say(line, kind="drive", v=v, w=w, press=press, seq=seq, nonce=gate["nonce"], epoch=gate["epoch"])


def test_hello_comes_first_and_says_who_and_what(live: Live) -> None:
    before = 1000 * time.monotonic()
    with live.open() as line:
        told = json.loads(line.recv(timeout=5))
    assert told["kind"] == "hello"
    assert before <= told["clock_ms"] <= 1000 * time.monotonic(), "no clock that someone may set back"
    assert told["you"]["role"] == "operator" and told["you"]["name"] == "operator"
    assert told["robot"]["kind"] == "SIM" and told["robot"]["drives"] is True
    assert len(told["tab"]) >= 16


def rate_of(line: ClientConnection, count: int) -> float:
    """Return how many states a second come: by our clock, because the simulator's slows on a busy machine."""
    hear(line, "state")
    begun = time.monotonic()
    states = [hear(line, "state") for _ in range(count)]
    rate = count / (time.monotonic() - begun)
    numbers = [state["seq"] for state in states]
    assert numbers == sorted(set(numbers)) and states[-1]["viewers"] == 1
    return rate


def test_states_come_often_while_the_robot_moves_and_less_often_at_rest_and_are_those_of_rest(live: Live) -> None:
    with live.open() as line:
        first = hear(line, "state")
        stands = first["stamp_s"] + 3
        hear(line, "state", true=lambda state: state["stamp_s"] > stands)
        at_rest = rate_of(line, 6)
        assert live.ask("POST", "/api/commands", {"text": "turn left"}, token=live.operator).status < 300
        hear(line, "state", true=lambda state: state["command"])
        moving = rate_of(line, 30)
    assert at_rest < 6 and at_rest < moving < 24  # twice as often, but where the simulator waits for its computer
    assert set(live.ask("GET", "/api/state", token=live.viewer).json) == set(first)


def test_before_the_first_snapshot_the_robots_link_is_told(live: Live, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(type(live.runtime), "state", lambda _: None)
    refused = live.ask("GET", "/api/state", token=live.viewer)
    assert refused.status == 503
    assert set(refused.json["robot"]) == {"url", "link", "age_s"}


def test_pictures_are_jpeg_behind_a_header_until_they_are_not_wanted(live: Live) -> None:
    with live.open() as line:
        picture = next(message for message in line if isinstance(message, bytes))
        kind, number, stamp = struct.unpack("<BxxxId", picture[:16])
        assert kind == 1 and number > 0 and stamp > 0
        assert picture[16:18] == b"\xff\xd8" and picture[-2:] == b"\xff\xd9"
        say(line, kind="want", camera=False)
        say(line, kind="echo", t=1.5)
        assert hear(line, "echo")["t"] == 1.5
        began, later = time.monotonic(), []
        while time.monotonic() - began < 0.7:
            later.append(line.recv(timeout=5))
        assert not any(isinstance(message, bytes) for message in later)


def test_an_echo_comes_back_as_it_went(live: Live) -> None:
    with live.open() as line:
        for t in (0, 12.25, -1e300):
            say(line, kind="echo", t=t)
            assert hear(line, "echo")["t"] == t


def test_a_held_key_moves_the_robot_and_letting_go_stops_it(live: Live) -> None:
    with live.open() as line:
        say(line, kind="lease", do="acquire", ref=7)
        assert hear(line, "answer")["ref"] == 7
        state = hear(line, "state", true=lambda told: told["gate"]["state"] == "armed")
        drive(line, state, 0.0, press=1, seq=1)
        state = hear(line, "state", true=lambda told: not told["gate"]["need_neutral"])
        for seq in range(2, 40):
            drive(line, state, 0.0, 0.8, press=1, seq=seq)
            state = hear(line, "state")
            if state["gate"]["w_rad_s"] > 0.5:
                break
        assert state["gate"]["source"] == "jog" and state["lease"]["holder"] == "operator"
        drive(line, state, 0.0, press=1, seq=100)
        hear(line, "state", true=lambda told: told["gate"]["w_rad_s"] == 0)
    acts = live.ask("GET", "/api/audit", token=live.operator).json["entries"]
    assert {"drive", "lease"} <= {entry["what"] for entry in acts}


def test_a_browser_that_goes_away_while_it_drives_stops_the_robot_at_once(live: Live) -> None:
    rows = live.robot.writer.rows
    with live.open() as line:
        say(line, kind="lease", do="acquire", ref=7)
        state = hear(line, "state", true=lambda told: told["gate"]["state"] == "armed")
        for seq in range(1, 60):
            drive(line, state, 0.0, 0.8 if seq > 3 else 0.0, press=17, seq=seq)
            state = hear(line, "state")
            if state["gate"]["w_rad_s"] > 0.5:
                break
        line.socket.shutdown(socket.SHUT_RDWR)
    live.until(lambda: rows[-1].w == 0.0)
    moved = max(number for number, row in enumerate(rows) if row.w != 0.0)
    assert rows[moved + 1].event == "stop"
    entries = live.ask("GET", "/api/audit", token=live.operator).json["entries"]
    assert "The browser went away while it drove." in [entry["remark"] for entry in entries]


def test_of_two_tabs_of_one_person_only_the_last_that_is_left_gives_control_back(live: Live) -> None:
    with live.open() as driving:
        say(driving, kind="lease", do="take", ref=1)
        assert hear(driving, "answer")["ok"]
        with live.open() as other:
            say(other, kind="lease", do="leave", ref=2)
            assert hear(other, "answer")["ok"]
            assert live.runtime.lease.holder is not None
        live.until(lambda: live.runtime.lease.is_last_page(live.runtime.lease.holder))
        say(driving, kind="lease", do="leave", ref=3)
        assert hear(driving, "answer", true=lambda told: told["ref"] == 3)["ok"]
        assert live.runtime.lease.holder is None


def test_a_viewer_does_not_drive_and_is_told(live: Live) -> None:
    with live.open(token=live.viewer) as line:
        drive(line, hear(line, "state"), 0.1, press=1, seq=1)
        refused = hear(line, "answer")
        assert refused["ok"] is False and refused["status"] == 403
        say(line, kind="lease", do="take", ref=3)
        assert hear(line, "answer", true=lambda told: told["ref"] == 3)["status"] == 403
        say(line, kind="stop")
        say(line, kind="echo", t=1)
        hear(line, "echo")
    assert live.runtime.lease.holder is None
    assert not any(
        order.v for order in live.robot.orders if order.source == "jog" and order.press == 1 and order.v == 0.1
    )


def test_words_are_answered_with_their_number_or_with_what_would_be_understood(live: Live) -> None:
    with live.open() as line:
        say(line, kind="command", text="turn right", source="chip", ref=41)
        accepted = hear(line, "answer")
        assert accepted["ok"] and accepted["status"] == 202 and accepted["ref"] == 41
        going = hear(line, "state", true=lambda told: told["command"] and told["command"]["id"] == accepted["id"])
        assert going["command"]["source"] == "chip" and going["command"]["state"] == "running"
        say(line, kind="command", text="levitate", source="typed", ref=42)
        refused = hear(line, "answer")
        assert not refused["ok"] and refused["status"] == 422 and "turn left" in refused["suggestions"]
        say(line, kind="stop")
        hear(line, "state", true=lambda told: told["command"] is None)


@pytest.mark.parametrize(
    ("message", "code"),
    [
        ("{", 1007),
        ("nonsense", 1007),
        ('{"kind":"echo","t":NaN}', 1007),
        ('{"kind":"drive","v":1e999}', 1007),
        ('{"kind":"drive","v":1,"v":0}', 1007),
        ('{"kind":"echo","t":"\\ud800"}', 1007),
        ("[" * 10000, 1007),
        (b"\x00\x01", 1003),
        ("x" * 70000, 1009),
        ('{"kind":"echo","t":1,"x":"' + "y" * 66000 + '"}', 1009),
    ],
    ids=lambda value: repr(value)[:24],
)
def test_what_is_no_message_ends_the_socket_with_a_reason(live: Live, message: str | bytes, code: int) -> None:
    with live.open() as line:
        hear(line, "hello")
        line.send(message)
        assert closed(line)[0] == code


@pytest.mark.parametrize(
    "message",
    [
        {"kind": "fly"},
        {"kind": "drive", "v": True, "w": 0, "press": 1, "seq": 1, "nonce": 1, "epoch": 1},
        {"kind": "drive", "v": "1", "w": 0, "press": 1, "seq": 1, "nonce": 1, "epoch": 1},
        {"kind": "drive"},
        {"kind": "lease", "do": "steal", "ref": 5},
        {"kind": "playback", "action": "speed", "ref": 5, "speed": "fast"},
        [],
        "stop",
        7,
        None,
    ],
    ids=str,
)
def test_a_message_of_another_form_is_refused_and_the_socket_lives(live: Live, message: object) -> None:
    with live.open() as line:
        line.send(json.dumps(message))
        refused = hear(line, "answer")
        assert refused["ok"] is False and refused["status"] == 422
        say(line, kind="echo", t=2)
        hear(line, "echo")


def test_a_flood_ends_with_1008_and_others_do_not_notice(live: Live) -> None:
    with live.open() as flood, live.open() as other:
        hear(flood, "hello")
        say_at_once(flood, TOO_MANY)
        assert closed(flood)[0] == 1008
        say(other, kind="echo", t=1)
        hear(other, "echo")


def test_messages_that_waited_while_the_console_stood_are_no_flood(live: Live) -> None:
    with live.open(max_queue=None) as line:
        hear(line, "hello")
        say(line, kind="echo", t=0)
        stalled = threading.Event()

        def stall() -> None:
            stalled.set()
            time.sleep(1.5)  # the event loop stands, as in a frozen process

        live.loop.call_soon_threadsafe(stall)
        assert stalled.wait(5.0)
        for number in range(MOST_PER_SECOND + 50):
            say(line, kind="echo", t=number)
        hear(line, "echo", true=lambda told: told["t"] == MOST_PER_SECOND + 49)


def test_a_stop_is_heard_even_from_one_who_floods(live: Live) -> None:
    with live.open() as line:
        say(line, kind="lease", do="acquire", ref=7)
        hear(line, "state", true=lambda told: told["gate"]["state"] == "armed")
        newest = stops(live)
        with live.open(max_queue=None) as flood:  # it reads all that it is answered
            say_at_once(flood, [*TOO_MANY[:200], *['{"kind":"stop","careless":true}'] * 100, *TOO_MANY])
            assert closed(flood)[0] == 1008
        hear(line, "state", true=lambda told: told["gate"]["reason"] == "stopped")
    assert stops(live) - newest <= 2 * MAX_RECORDED_STOPS


def test_a_flood_of_stops_ends_the_socket_and_writes_little(live: Live) -> None:
    newest = stops(live)
    with live.open() as flood:
        say_at_once(flood, ['{"kind":"stop"}'] * (FLOOD + 500))
        assert closed(flood) == (1008, f"More than {FLOOD} messages a second.")
    assert stops(live) - newest <= 5 * MAX_RECORDED_STOPS


def stops(live: Live) -> int:
    """How many stops the history holds."""
    return sum(
        entry.what == "stop" for entry in live.on_loop(lambda: live.runtime.history.newest_first(commands_only=False))
    )


def test_a_stuck_viewer_is_dropped_and_nobody_waits_for_it(live: Live, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("console.api.state_socket.SEND_TIME_S", 0.5)
    stuck = socket.create_connection(("127.0.0.1", live.port))
    stuck.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    stuck.sendall(
        (
            f"GET /ws HTTP/1.1\r\nHost: 127.0.0.1:{live.port}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
            "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
            f"Authorization: Bearer {live.viewer}\r\n\r\n"
        ).encode()
    )
    try:
        live.until(lambda: len(live.runtime.broadcaster.viewers) == 1)
        with live.open() as other:
            began = time.monotonic()
            for _ in range(20):
                hear(other, "state")
            assert time.monotonic() - began < 8
            live.until(lambda: len(live.runtime.broadcaster.viewers) == 1, 20)
    finally:
        stuck.close()


def test_leaving_is_noticed_at_once(live: Live) -> None:
    with live.open() as line:
        hear(line, "state")
        assert len(live.runtime.broadcaster.viewers) == 1
    live.until(lambda: not live.runtime.broadcaster.viewers, 3)
    assert not live.runtime.scene.tabs and len(live.runtime.sockets) == 0


def test_no_more_sockets_of_one_person_than_there_is_room(live: Live, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("console.access.open_sockets.MOST_OF_ONE", 2)
    with live.open() as one, live.open() as two, live.open() as three:
        assert closed(three) == (1013, "You have too many sockets open; close some tabs.")
        hear(one, "state")
        hear(two, "state")


def test_the_console_ends_in_the_moment_in_which_a_browser_says_good_bye(live: Live) -> None:
    """Its good-bye has been read and nobody has been told yet: there uvicorn's own way to end raises."""
    known = set(live.server.server_state.connections)

    def part() -> None:
        (line,) = [one for one in live.server.server_state.connections - known if isinstance(one, TimeoutSocket)]
        line.conn.receive_data(b"\x88\x80\x00\x00\x00\x00")  # a masked Close without a reason
        line.shutdown()

    with live.open():
        live.on_loop(part)


def test_a_connection_that_is_gone_is_not_aborted_any_more(live: Live) -> None:
    """asyncio forgets the loop of a transport that closed after its buffer was sent: aborting it raises."""
    known = set(live.server.server_state.connections)
    with live.open() as line:
        hear(line, "state")
        (ours,) = [one for one in live.server.server_state.connections - known if isinstance(one, TimeoutSocket)]
    live.until(lambda: ours not in live.server.server_state.connections, 3)
    ours.transport = Mock()
    live.on_loop(ours._part)
    ours.transport.abort.assert_not_called()
