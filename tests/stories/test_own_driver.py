"""*Write your own driver in 40 lines*, done from top to bottom, up to a command that drives it in the console."""

import json
import os
import re
import shlex
import signal
import subprocess
import sys
import time
import urllib.request
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from tempfile import mkdtemp
from typing import Any

import pytest

from core.robots.conformance import Interruption, check_robot
from tests.emulators.toy_robot import ToyRobot

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "static/docs/how-to/write-your-own-driver.md").read_text()

TRIES = 3  # examinations of a robot: other tests take the computer's time
UNCONDITIONAL = ("standing after reconnect", "close")  # no busy computer excuses what fails here


def fences(language: str) -> list[str]:
    """The blocks of the page in that language, in order."""
    return fences_of(PAGE, language)


def fences_of(page: str, language: str) -> list[str]:
    """The blocks of a page in that language, in order."""
    return re.findall(rf"^ *```{language}\n(.*?)^ *```", page, re.M | re.S)


def environment(home: Path) -> dict[str, str]:
    paths = [str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(paths), "BECKON_HOME": str(home)}


def run(folder: Path, words: list[str], answer: str = "") -> str:
    """Run a command of the page → what it prints."""
    done = subprocess.run(
        [sys.executable, "-m", *words],
        cwd=folder,
        env=environment(folder / "home"),
        input=answer,
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


class Client:
    """A program with the operator's key."""

    def __init__(self, base: str, key: str) -> None:
        self._base, self._key = base, key

    def ask(self, path: str, body: dict[str, str] | None = None) -> Any:
        headers = {"Authorization": f"Bearer {self._key}", "Content-Type": "application/json"}
        content = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self._base + path, content, headers)
        with urllib.request.urlopen(request, timeout=60) as answer:
            return json.load(answer)


@contextmanager
def console(folder: Path, words: list[str]) -> Iterator[Client]:
    """`beckon run …` of the page, on any free port and without a browser."""
    home = Path(mkdtemp(dir=folder))
    said = home / "said"
    command = [sys.executable, "-m", *words, "--port", "0", "--no-browser"]
    with said.open("w") as output:
        process = subprocess.Popen(
            command, cwd=folder, env=environment(home), stdout=output, stderr=subprocess.STDOUT
        )
    try:
        links = until(lambda: re.findall(r"(http://\S+/)#t=(\S+)", said.read_text()), 60.0)
        client = Client(*links[0])
        until(lambda: client.ask("api/state")["robot"]["link"] == "live", 100.0)
        yield client
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait(100)


def until(true: Callable[[], Any], seconds: float) -> Any:
    end = time.monotonic() + seconds
    while not (value := true()):
        assert time.monotonic() < end, "it never came"
        time.sleep(0.1)
    return value


def drive(client: Client, *, warned: bool = False) -> None:
    """Say the page's words, and a short way. `warned`: there may be warnings."""
    for text in ("turn left", "continue 0.3 meters"):
        number = client.ask("api/commands", {"text": text})["id"]
        ended = until(
            lambda number=number: [
                one
                for one in client.ask("api/commands/history")["commands"]
                if one["id"] == number and one["ended_s"]
            ],
            200.0,
        )
        assert ended[0]["state"] == "done", ended
    state = client.ask("api/state")
    pose, warnings = state["pose"], [one["text"] for one in state["notices"] if one["level"] == "warning"]
    assert warned or warnings == []
    assert abs(pose["heading_rad"] - 1.5708) < 0.1 and abs(pose["y_m"] - 0.3) < 0.05, pose


def begun(folder: Path) -> list[str]:
    """Do what the page begins with → its other lines."""
    (description,) = fences("toml")
    (folder / "robot.toml").write_text(description)
    first, *others = [line.strip() for fence in fences("sh") for line in fence.splitlines()]
    program, *words = shlex.split(first)
    assert program == "beckon" and len(others) >= 6
    run(folder, ["console", *words])
    assert len((folder / "my_robot.py").read_text().splitlines()) <= 40
    return others


@pytest.mark.campaign
def test_the_page_s_checks_work_in_their_order(tmp_path: Path) -> None:
    for line in begun(tmp_path):
        program, *words = shlex.split(line)
        if "--interactive" in words:
            assert "asks you to pull" in PAGE
        elif words[0] != "run":
            printed = run(tmp_path, [{"beckon": "console", "pytest": "pytest"}[program], *words], answer="y\n")
            assert "check" not in words or printed.splitlines()[-1].startswith("All ")


@pytest.mark.campaign
def test_the_page_s_consoles_drive_the_robot(tmp_path: Path) -> None:
    started = [words for line in begun(tmp_path) if (words := shlex.split(line)[1:])[0] == "run"]
    assert len(started) == 2
    with ThreadPoolExecutor() as shells:
        for done in [shells.submit(driven, tmp_path, words) for words in started]:
            done.result()


def driven(folder: Path, words: list[str]) -> None:
    with console(folder, ["console", *words]) as client:
        drive(client)


def test_the_example_of_the_page_drives_a_robot(tmp_path: Path) -> None:
    (source,) = fences("python")
    assert len(source.splitlines()) <= 45
    (tmp_path / "rover.py").write_text(source)
    robot = ToyRobot()
    robot.start()
    address = robot.url.partition(".py:")[2]
    interruption = Interruption(robot.stop, robot.start)
    for _ in range(TRIES):
        report = check_robot(f"py:{tmp_path}/rover.py:{address}", drive=True, interruption=interruption)
        if report.passed or any(check.name in UNCONDITIONAL and not check.passed for check in report.checks):
            break
    robot.stop()
    assert [(check.name, check.advice) for check in report.checks if not check.passed] == []
    assert {"stop", "silence", "reconnect", "standing after reconnect", "close"} <= {
        check.name for check in report.checks
    }
