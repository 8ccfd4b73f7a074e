"""The connection over REST: what was found, another look, and the robot file; with rights, bounds and sentences."""

import threading
import time
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest

from console.access.logins import Person
from console.connection.probe_worker import check_sends_pictures
from core.errors import Unavailable
from core.robots.robot_file import load_robot_file
from core.robots.usb_camera import stream_options
from tests.console.live import Live, Reply
from tests.emulators.foxglove import FoxgloveEmulator
from tests.emulators.world import World
from tests.emulators.zenoh_robot import ZenohEmulator


@pytest.fixture(scope="module")
def emulator() -> Iterator[FoxgloveEmulator]:
    world = World()
    emulator = FoxgloveEmulator(world)
    emulator.start()
    world.start()
    yield emulator
    world.stop()
    emulator.stop()


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("home")


@pytest.fixture(scope="module")
def live(emulator: FoxgloveEmulator, home: Path) -> Iterator[Live]:
    with Live(home, url=f"{emulator.url}?battery=none") as console:
        yield console


def url_of(live: Live) -> str:
    return live.robot.profile.url


def post(live: Live, path: str, body: dict[str, Any], token: str | None = None) -> Reply:
    return live.ask("POST", f"/api/robot/{path}", {"url": url_of(live), **body}, token=token or live.operator)


def roles_of(connection: dict[str, Any]) -> dict[str, Any]:
    return {one["role"]: one for one in connection["parts"][0]["findings"]["roles"]}


def test_what_was_found_is_shown_to_everybody(live: Live) -> None:
    answer = live.ask("GET", "/api/robot/connection", token=live.viewer)
    assert answer.status == 200 and answer.json["why_not"] == ""
    found = answer.json["connection"]
    roles = roles_of(found)
    assert roles["scan"]["used"][0]["topic"] == "/scan" and roles["battery"]["used"] == []
    assert found["lasers"][0]["mounting"] == "robot" and found["failsafe"]


@pytest.mark.campaign
def test_another_look_hears_the_topics_that_were_chosen_and_moves_nothing(
    live: Live, emulator: FoxgloveEmulator
) -> None:
    before = len(emulator.received)
    choice = [{"role": "battery", "topics": ["/battery_state"]}, {"role": "odometry", "topics": []}]
    answers: list[Reply] = []
    look = threading.Thread(target=lambda: answers.append(post(live, "probe", {"topics": choice})))
    look.start()
    time.sleep(0.5)
    at_once = post(live, "probe", {})
    assert at_once.status == 409 and "being looked at already" in at_once.json["detail"]
    look.join()
    (answer,) = answers
    assert answer.status == 200 and answer.json["url"] == url_of(live)  # not without the options that were overruled
    roles = roles_of(answer.json)
    assert roles["battery"]["used"][0]["topic"] == "/battery_state" and roles["odometry"]["used"] == []
    assert roles["scan"]["used"][0]["rate_hz"] > 1
    assert len(emulator.received) == before


def test_a_robot_on_zenoh_is_looked_at_too(live: Live) -> None:
    world = World()
    emulator = ZenohEmulator(world)
    emulator.start()
    world.start()
    try:
        answer = post(live, "probe", {"url": emulator.url}, live.admin)
    finally:
        world.stop()
        emulator.stop()
    assert answer.status == 200 and roles_of(answer.json)["scan"]["used"][0]["topic"] == "/scan", answer.json


def test_a_robot_file_is_written_once_and_replaced_when_that_is_said(live: Live, home: Path) -> None:
    places = {
        "lasers": {"laser": {"x_m": 0.1, "heading_rad": 0.5, "time_offset_s": 0.1}},
        "cameras": {"camera": {"x_m": 0.05, "pitch_rad": 0.1}},
    }
    body = {"name": "Marvin 2", "radius_m": 0.2, "topics": [{"role": "scan", "topics": ["/scan"]}], **places}
    written = post(live, "file", body)
    assert written.status == 201
    path = home / "robots" / "marvin-2.toml"
    assert written.json["path"] == str(path) and written.json["command"] == f"beckon run --robot {path}"
    assert path.read_text() == written.json["text"]
    file = load_robot_file(path)
    assert (file.url, file.name, file.radius) == (url_of(live), "Marvin 2", 0.2)
    assert file.robot == {"scan": "/scan"} and file.lasers["laser"].time_offset == 0.1
    assert file.lasers["laser"].heading_deg == pytest.approx(28.6479) and file.cameras["camera"].x == 0.05

    again = post(live, "file", {"name": "marvin 2", "radius_m": 0.3})
    assert again.status == 409 and "replace it" in again.json["detail"]
    assert load_robot_file(path) == file
    assert post(live, "file", {"name": "marvin 2", "radius_m": 0.3, "replace": True}).status == 201
    assert load_robot_file(path).radius == 0.3
    assert live.ask("GET", "/api/robot/connection", token=live.viewer).json["files"] == ["marvin-2.toml"]


@pytest.mark.parametrize(
    ("path", "body", "status", "words"),
    [
        ("probe", {"url": "foxglove://127.0.0.1:2"}, 503, "No foxglove bridge at 127.0.0.1:2"),
        ("probe", {"url": "nix://a"}, 422, "There is no robot of the kind 'nix'"),
        ("open", {"url": "log:walk.mcap"}, 409, "drives a real robot and stays with it"),
        ("probe", {"url": "sim:lab"}, 422, "needs no robot file"),
        ("probe", {"url": "foxglove://127.0.0.1:1+log:a.mcap"}, 422, "needs no robot file"),
        ("probe", {"url": "py:own.py:"}, 422, "named where the console is started"),
        ("probe", {"url": "/etc/robot.toml"}, 422, "Type the robot's URL"),
        ("probe", {"topics": [{"part": 1, "role": "scan", "topics": ["/scan"]}]}, 422, "no such part"),
        ("probe", {"topics": [{"role": "scan", "topics": ["/nowhere"]}]}, 503, "no topic /nowhere"),
        ("file", {"name": "a", "topics": [{"role": "scan", "topics": ["a b"]}]}, 422, "name of a topic"),
        ("file", {"name": ""}, 422, "has not the form"),
        ("file", {"name": "a", "radius_m": -1.0}, 422, "has not the form"),
        ("file", {"name": "a", "lasers": {"laser": {"x_m": 99.0}}}, 422, "has not the form"),
    ],
)
def test_bad_input_gets_a_sentence(
    live: Live, home: Path, path: str, body: dict[str, Any], status: int, words: str
) -> None:
    answer = post(live, path, body, live.admin)
    assert (answer.status, words in answer.json["detail"]) == (status, True), answer.json
    assert not (home / "robots" / "a.toml").exists()


def test_an_operator_reaches_nothing_of_this_computer_and_what_was_asked_stands_in_the_history(live: Live) -> None:
    asked = "camera://http/ann:word@127.0.0.1:1/admin?reboot=1"
    answer = post(live, "probe", {"url": asked})
    assert answer.status == 403 and "--connect 127.0.0.1" in answer.json["detail"]
    refused = post(live, "file", {"name": "b", "url": "camera:///etc/hostname"})
    assert refused.status == 403 and "files and devices" in refused.json["detail"]
    row = next(one for one in live.runtime.history.newest_first(commands_only=False) if "look" in one.what)
    assert row.words == asked.replace("word", "***")
    assert row.state == "refused" and row.remark == answer.json["detail"]


def test_a_camera_of_an_operator_sends_pictures_and_nothing_else() -> None:
    heard: list[str] = []

    class Page(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            heard.append(self.path)
            self.send_response(302 if self.path == "/moved" else 200)
            self.send_header("Location", "/elsewhere")
            self.send_header("Content-Type", "text/html")
            self.end_headers()

        def log_message(self, *_: object) -> None: ...

    with ThreadingHTTPServer(("127.0.0.1", 0), Page) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        for path in ("/moved", "/page"):
            with pytest.raises(Unavailable, match="sends no pictures"):
                check_sends_pictures(f"http://127.0.0.1:{server.server_port}{path}")
        server.shutdown()
    assert heard == ["/moved", "/page"]
    options = stream_options("http://10.0.0.1/a", restrained=True)
    assert "max_redirects;0" in options and "hls" not in options and "file" not in options


def test_who_watches_or_does_not_drive_writes_nothing(live: Live) -> None:
    assert post(live, "probe", {}, live.viewer).status == 403
    assert post(live, "file", {"name": "x"}, live.viewer).status == 403
    live.runtime.lease.take(Person("another", "Ann", "operator"), time.monotonic())
    try:
        assert "Ann drives now" in post(live, "probe", {}).json["detail"]
        assert post(live, "file", {"name": "x"}).status == 409
    finally:
        live.runtime.lease.holder = None


def test_the_type_of_speeds_is_switched_by_operators_and_only_where_it_was_guessed(live: Live) -> None:
    asked = {"type": "TwistStamped"}
    assert live.ask("POST", "/api/robot/speeds_type", asked, token=live.viewer).status == 403
    said = live.ask("POST", "/api/robot/speeds_type", asked, token=live.operator)
    assert said.status == 422 and "understands the requests" in said.json["detail"]  # this robot says its type
    assert live.ask("POST", "/api/robot/speeds_type", {"type": "Pose"}, token=live.operator).status == 422
