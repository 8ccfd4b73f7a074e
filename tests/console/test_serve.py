"""The console as a person starts and ends it."""

import contextlib
import http.client
import json
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import time
import urllib.error
import urllib.request
from pathlib import Path
from types import SimpleNamespace

import psutil
import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from console.__main__ import main
from console.access.browser import written
from console.access.guard import Access
from console.data_folder import locked
from console.listening import announce
from console.options import Options, check, hosts_of
from console.serve import warn_without_words
from core.errors import BadInput
from core.gate import Limits, read_trace
from core.gate import check as check_trace
from core.sentences import static_folder
from core.speech.recognition import engines
from core.speech.settings import SpeechSettings
from tests.core.robots.test_robot_file import DRIVER

REPOSITORY = Path(__file__).parents[2]
CAMPAIGN = pytest.mark.campaign


def heed_closed_terminals() -> None:
    """Whoever runs the tests may ignore a closed terminal, as under nohup; the console would then do so, too."""
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


def test_where_nothing_reads_words_the_start_says_so_and_what_to_do(monkeypatch, capsys):
    monkeypatch.setattr(engines, "find", lambda _: None)
    monkeypatch.setattr(engines, "has_sphinx", lambda: False)
    warn_without_words(SpeechSettings())
    assert "beckon models get whisper-tiny.en" in capsys.readouterr().err
    monkeypatch.setattr(engines, "has_sphinx", lambda: True)
    warn_without_words(SpeechSettings())
    assert capsys.readouterr().err == ""


class Started:
    """`beckon run` and what it says."""

    def __init__(self, folder: Path, *options: str) -> None:
        self.home = folder / "home"
        command = [sys.executable, "-m", "console", "run", "--no-browser", "--data", str(self.home), *options]
        self.said, self.complained = folder / "said", folder / "complained"
        with self.said.open("w") as said, self.complained.open("w") as complained:
            self.process = subprocess.Popen(
                command, cwd=REPOSITORY, stdout=said, stderr=complained, preexec_fn=heed_closed_terminals
            )

    def links(self, number: int) -> list[str]:
        end = time.monotonic() + 300
        while time.monotonic() < end and self.process.poll() is None:
            links = re.findall(r"http://\S+", self.said.read_text())
            if len(links) == number:
                return links
            time.sleep(0.05)
        raise AssertionError(self.said.read_text() + self.complained.read_text())

    @property
    def complaint(self) -> str:
        """What it complains of, after the line with which it starts."""
        starting, complaint = self.complained.read_text().split("\n", 1)
        assert starting.startswith("Starting ")
        return complaint

    def end(self, how: signal.Signals) -> float:
        """Send a signal → how long the end took [s]."""
        began = time.monotonic()
        self.process.send_signal(how)
        self.process.wait(120)
        return time.monotonic() - began


@pytest.fixture
def begin(tmp_path: Path):
    """Start consoles; none outlives the test."""
    started: list[Started] = []

    def start(*options: str) -> Started:
        folder = tmp_path / str(len(started))
        folder.mkdir()
        started.append(Started(folder, *options))
        return started[-1]

    yield start
    for one in started:
        if one.process.poll() is None:
            one.process.kill()
            one.process.wait()


def test_what_is_improbable_in_a_robot_file_is_said_at_the_start(begin, tmp_path: Path) -> None:
    (tmp_path / "my_robot.py").write_text(DRIVER)
    url = f"py:{tmp_path}/my_robot.py:x"
    (tmp_path / "robot.toml").write_text(f'url = "{url}"\nradius = 0.2\n[lasers.top]\nx = 0.1\nheading_deg = 1.5708')
    console = begin("--port", "0", "--robot", str(tmp_path / "robot.toml"))
    console.links(2)
    console.end(signal.SIGTERM)
    assert "lasers.top.heading_deg = 1.5708" in console.complaint


def test_it_tells_two_addresses_keeps_its_secrets_and_ends_promptly_with_sockets_open(begin) -> None:
    console = begin("--port", "0")
    driving, watching = console.links(2)
    base, _, token = driving.partition("#t=")
    assert watching.partition("#t=")[0] == base and len(token) >= 43
    request = urllib.request.Request(base + "api/me", headers={"Authorization": f"Bearer {token}"})
    with urllib.request.urlopen(request, timeout=60) as answer:
        assert json.load(answer)["role"] == "admin"
    family = psutil.Process(console.process.pid).children(recursive=True)
    shown = " ".join(" ".join(one.cmdline()) for one in [psutil.Process(console.process.pid), *family])
    assert token not in shown
    bearer = {"Authorization": f"Bearer {token}"}
    lines = [
        connect(base.replace("http", "ws") + "ws", additional_headers=bearer, proxy=None, compression=None)
        for _ in range(3)
    ]
    for line in lines:
        assert "hello" in str(line.recv(timeout=10))
    took = console.end(signal.SIGTERM)
    assert took < 4, "an idle machine takes less than a second"
    assert console.process.returncode in (0, -signal.SIGTERM)
    for line in lines:
        with pytest.raises(ConnectionClosed) as end:
            while True:
                line.recv(timeout=5)
        assert end.value.rcvd is not None and end.value.rcvd.code == 1012
    assert not [one for one in family if one.is_running() and one.status() != psutil.STATUS_ZOMBIE]
    kept = b"".join(path.read_bytes() for path in console.home.rglob("*") if path.is_file())
    for secret in (token, watching.partition("#t=")[2]):
        assert secret.encode() not in kept
    assert console.complaint == ""


@pytest.mark.parametrize("how", [signal.SIGINT, pytest.param(signal.SIGHUP, marks=CAMPAIGN)], ids=str)
def test_ctrl_c_and_a_closed_terminal_end_it_without_a_traceback(begin, how: signal.Signals) -> None:
    console = begin("--port", "0", "--no-auth")
    (link,) = console.links(1)
    assert "#" not in link
    console.end(how)
    assert console.process.returncode in (0, 130)
    assert "Traceback" not in console.complained.read_text()
    written = [console.home, *console.home.rglob("*")]
    assert len(written) > 2 and {path.stat().st_mode & 0o077 for path in written} == {0}, "for its owner alone"


def test_with_log_json_every_line_of_the_log_is_an_object(begin) -> None:
    console = begin("--port", "0", "--no-auth", "--log-json")
    console.links(1)
    family = psutil.Process(console.process.pid).children(recursive=True)
    console.process.terminate()
    for one in family:  # as systemd stops a service: all at once
        with contextlib.suppress(psutil.NoSuchProcess):
            one.terminate()
    console.end(signal.SIGTERM)
    lines = [json.loads(line) for line in console.complained.read_text().splitlines()]
    assert {type(line) for line in lines} <= {dict}
    assert not [line for line in lines if line["level"] not in ("INFO", "WARNING")]


def test_with_log_json_a_start_that_fails_is_one_object_with_its_sentence(begin, tmp_path: Path) -> None:
    """As systemd's journal has it: no traceback of the web server, no line that is no JSON."""
    file = tmp_path / "robot.toml"
    file.write_text('url = "sim:lab"\n')
    console = begin("--port", "0", "--log-json", "--robot", str(file))
    assert console.process.wait(60) == 1
    (line,) = [json.loads(line) for line in console.complained.read_text().splitlines()]
    assert line["level"] == "ERROR" and "--robot sim:lab" in line["message"]


def test_the_unit_of_systemd_keeps_keys_out_of_the_journal_and_errors_in_it() -> None:
    """Without a target of its own, standard error goes where standard output goes."""
    unit = dict(
        line.split("=", 1)
        for line in (static_folder() / "docs/service/beckon.service").read_text().splitlines()
        if "=" in line and not line.startswith("#")
    )
    assert unit["StandardOutput"] == "null" and unit["StandardError"] == "journal"


@pytest.fixture
def refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    """What `beckon run` says, in this process, where it cannot even begin; and with which code it ends."""
    monkeypatch.setattr("console.serve.take_precedence", lambda _: None)
    interval, mask = sys.getswitchinterval(), os.umask(0o077)

    def run(*options: str) -> tuple[int, str]:
        code = main(["run", "--no-browser", "--data", str(tmp_path / "home"), *options])
        said, complained = capsys.readouterr()
        starting, told = complained.split("\n", 1)
        assert said == "" and starting.startswith("Starting ") and told.count("\n") == 1
        return code, told

    yield run
    sys.setswitchinterval(interval)
    os.umask(mask)


def test_a_port_in_use_is_told_in_one_sentence(refused) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        code, told = refused("--port", str(port))
    assert code == 1 and str(port) in told and "--port 0" in told


def test_a_second_console_on_one_data_folder_is_refused_in_one_sentence(refused, tmp_path: Path) -> None:
    home = tmp_path / "shared"
    with locked(home) as lock:
        lock.announce(8420)
        code, told = refused("--port", "0", "--data", str(home))
    assert code == 1 and told.startswith("beckon: Another console") and "--data" in told
    assert str(home) in told and f"process {os.getpid()}, port 8420" in told
    assert {path.name for path in home.iterdir()} == {"lock"}


@pytest.mark.parametrize(
    "options", [["--robot", "log:/nowhere/at/all.mcap"], pytest.param(["--robot", "warp:9"], marks=CAMPAIGN)], ids=str
)
def test_a_robot_that_cannot_be_had_is_told_in_a_sentence(begin, options: list[str]) -> None:
    console = begin("--port", "0", *options)
    assert console.process.wait(300) == 1
    told = console.complaint
    assert told.startswith("beckon: ") and told.count("\n") == 1
    assert console.said.read_text() == ""


@pytest.mark.campaign
def test_a_robot_that_is_being_opened_does_not_keep_it_from_ending(begin, tmp_path: Path) -> None:
    driver, begun = tmp_path / "slow.py", tmp_path / "begun"
    driver.write_text(f"import os, time\nopen({str(begun)!r}, 'w').write(str(os.getpid()))\ntime.sleep(60)\n")
    console, end = begin("--port", "0", "--robot", f"py:{driver}:"), time.monotonic() + 300
    while not (begun.exists() and begun.read_text()):
        assert time.monotonic() < end
        time.sleep(0.01)
    opening = psutil.Process(int(begun.read_text()))
    time.sleep(1.0)
    assert console.end(signal.SIGINT) < 5
    assert console.process.returncode in (0, 130)
    assert "Traceback" not in console.complained.read_text()
    assert console.said.read_text() == ""
    assert not opening.is_running() or opening.status() == psutil.STATUS_ZOMBIE


@pytest.mark.campaign
def test_a_trace_that_cannot_be_written_is_told_in_a_sentence(begin, tmp_path: Path) -> None:
    console = begin("--port", "0", "--gate-trace", str(tmp_path / "nowhere" / "gate.csv"))
    assert console.process.wait(300) == 1
    told = console.complaint
    assert told.startswith("beckon: --gate-trace ") and told.count("\n") == 1


def test_a_goal_that_drives_ends_with_the_console(begin, tmp_path: Path) -> None:
    trace = tmp_path / "gate.csv"
    console = begin("--port", "0", "--gate-trace", str(trace))
    base, _, token = console.links(2)[0].partition("#t=")
    head = {"Authorization": f"Bearer {token}", "Content-Type": "application/json"}

    def turns() -> bool:
        rows = read_trace(trace) if trace.exists() and "\n" in trace.read_text() else []
        return bool(rows) and abs(rows[-1].w) > 0.3

    while not turns():
        body = json.dumps({"text": "turn left"}).encode()
        with contextlib.suppress(urllib.error.HTTPError):  # 503 until the robot is there
            urllib.request.urlopen(urllib.request.Request(base + "api/commands", body, head), timeout=60).close()
        deadline = time.monotonic() + 3
        while not turns() and time.monotonic() < deadline:
            time.sleep(0.1)
    told = time.monotonic()
    console.end(signal.SIGTERM)
    rows = read_trace(trace)
    last = max(number for number, row in enumerate(rows) if row.v or row.w)
    assert rows[last].t_mono_ns * 1e-9 - told < 0.1
    assert rows[last + 1].event == "stop"  # at the same instant of a simulator's clock
    assert check_trace(rows, Limits()) == []


@pytest.mark.parametrize(
    "options",
    [
        Options(no_auth=True, host="0.0.0.0"),
        Options(no_auth=True, host="192.168.1.2"),
        Options(no_auth=True, robot="log:walk.mcap"),
        Options(no_auth=True, robot="srv1://robot"),
        Options(host="0.0.0.0"),
        Options(host="::"),
        Options(host="0"),
        Options(host=""),
        Options(allow_hosts=("robot.lan:8420",)),
        Options(allow_hosts=("",)),
        Options(allow_hosts=("0.0.0.0",)),
        Options(port=70000),
        Options(port=-1),
    ],
    ids=lambda options: f"{options.robot} {options.host} {options.port}",
)
def test_options_that_would_not_be_safe_are_refused(options: Options) -> None:
    with pytest.raises(BadInput):
        check(options)


def test_a_console_answers_to_loopback_names_and_its_own() -> None:
    assert hosts_of("127.0.0.1") == {"127.0.0.1", "localhost", "[::1]"}
    assert "192.168.1.2" in hosts_of("192.168.1.2")
    assert "[fe80::1]" in hosts_of("fe80::1")
    assert hosts_of("0.0.0.0", "Robot.lan", "fe80::1") == hosts_of("127.0.0.1") | {"robot.lan", "[fe80::1]"}
    check(Options(host="0.0.0.0", allow_hosts=("robot.lan",)))
    check(Options(host="192.168.1.2"))


@pytest.mark.campaign
def test_a_wildcard_answers_to_the_names_that_are_allowed_and_warns_once(begin) -> None:
    console = begin("--port", "0", "--host", "0.0.0.0", "--allow-host", "Robot.lan")
    driving, _ = console.links(2)
    assert driving.startswith("http://robot.lan:")
    port = int(driving.partition("/#")[0].rpartition(":")[2])
    statuses = {}
    for name in ("robot.lan", "127.0.0.1", "0.0.0.0", "evil.example"):
        line = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
        line.request("GET", "/", headers={"Host": f"{name}:{port}"})
        statuses[name] = line.getresponse().status
        line.close()
    assert statuses == {"robot.lan": 200, "127.0.0.1": 200, "0.0.0.0": 403, "evil.example": 403}
    console.end(signal.SIGTERM)
    told = console.complaint
    assert told.count("\n") == 1 and "TLS" in told


def test_a_browser_that_is_slow_to_open_keeps_nobody_waiting(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    opened = threading.Event()
    release = threading.Event()
    monkeypatch.setattr("console.access.browser.webbrowser.open", lambda _: (opened.set(), release.wait(10)))
    monkeypatch.setattr("console.listening.ONCE_LIFE_S", 0.0)
    began = time.monotonic()
    announce(Options(data=tmp_path), 8420, Access())
    assert time.monotonic() - began < 8  # of the 10 s that the browser takes
    assert opened.wait(5)
    release.set()


def test_the_browser_gets_its_key_by_a_file_for_this_user_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened: list[str] = []
    seen = threading.Event()
    monkeypatch.setattr("console.access.browser.webbrowser.open", opened.append)
    monkeypatch.setattr("console.access.browser.time", SimpleNamespace(sleep=lambda _: seen.wait(10)))
    access = Access()
    announce(Options(data=tmp_path), 8420, access)
    deadline = time.monotonic() + 10
    while not opened and time.monotonic() < deadline:
        time.sleep(0.01)
    page = tmp_path / "open.html"
    assert opened == [page.as_uri()], "no key in the command line"
    assert page.stat().st_mode & 0o777 == 0o600
    (address,) = set(re.findall(r"http://127\.0\.0\.1:8420/#t=[\w-]+", page.read_text()))
    key = address.partition("#t=")[2]
    assert access.logins.open(key, "", time.monotonic() + 121.0) is None, "it is good for two minutes"
    assert access.logins.open(key, "", time.monotonic()) is not None
    seen.set()
    while page.exists() and time.monotonic() < deadline:
        time.sleep(0.01)
    assert not page.exists()


def test_a_page_that_someone_left_there_is_not_followed(tmp_path: Path) -> None:
    (tmp_path / "theirs").write_text("")
    (tmp_path / "open.html").symlink_to(tmp_path / "theirs")
    written("http://127.0.0.1:8420/#t=<key>", tmp_path)
    assert (tmp_path / "theirs").read_text() == ""
    assert "#t=&lt;key&gt;" in (tmp_path / "open.html").read_text()


def test_a_mistyped_setting_is_wrong_usage(refused, tmp_path: Path) -> None:
    settings = tmp_path / "own.toml"
    settings.write_text("[limits]\nv_max = -1\n")
    code, told = refused("--port", "0", "--settings", str(settings))
    assert code == 2 and told.startswith("beckon: own.toml")
