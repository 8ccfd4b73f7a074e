"""The pages *Run three robots* and *Keys and certificates*: each command in a fence is tried, from top to bottom."""

import contextlib
import http.client
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import unicodedata
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import console.fleet_server.serve
import console.options
import console.serve
from console.__main__ import main
from console.access.records import AccessFile
from console.cli import build_parser
from console.fleet.authority import Authority
from console.fleet_server.runtime import FleetRoles
from tests.console.test_documented_requests import FENCE, HOW_TO
from tests.core.robots.links import until
from tests.emulators.zenoh_robot import free_port

ROOT = Path(__file__).parents[3]
START_TIME_S = 300.0  # on a busy machine

pytestmark = pytest.mark.skipif(
    shutil.which("openssl") is None, reason="a certificate needs openssl: apt install openssl"
)


def fences(page: str) -> list[str]:
    return FENCE.findall((HOW_TO / f"{page}.md").read_text())


def test_every_beckon_command_of_both_pages_does_what_it_says_and_servers_take_what_the_others_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("BECKON_HOME", str(tmp_path / "home"))
    checked: list[Any] = []
    monkeypatch.setattr(console.serve, "serve", checked.append)
    monkeypatch.setattr(console.fleet_server.serve, "serve_fleet", checked.append)
    pages = [*fences("run-three-robots"), *fences("keys-and-certificates")]
    lines = [line for fence in pages for line in fence.replace("\\\n", " ").splitlines()]
    commands = [os.path.expandvars(line) for line in lines if line.startswith("beckon ")]
    for line in commands:
        chosen = build_parser().parse_args(shlex.split(line)[1:])
        assert chosen.run(chosen) == 0, line
    fleet, *consoles = checked
    console.options.check(fleet.web)
    for options in consoles:  # their certificates are there, and go with their keys
        console.options.check(options)
    home = tmp_path / "home" / "fleet"
    assert len(commands) == 14 and [one.fleet_name for one in consoles] == ["robot1", "robot2", "robot3", "robot1"]
    assert [one.name for one in Authority(home).certificates()] == ["robot2", "robot3", "robot1"]
    assert FleetRoles(home).read() == {"Ann": {"robot1": "operator", "robot2": None}}
    assert "Ann" in {one.name for one in AccessFile(home).read().keys.values()}


def test_a_role_is_set_for_who_has_the_key_however_a_shell_writes_the_name(tmp_path: Path) -> None:
    for command in (["token", "add", "Änne", "--role", "operator"], ["fleet", "role", "Änne", "robot1", "none"]):
        form = "NFC" if command[0] == "token" else "NFD"
        line = [unicodedata.normalize(form, word) for word in command]
        assert main([*line, "--data", str(tmp_path / "fleet" if form == "NFC" else tmp_path)]) == 0
    [key] = AccessFile(tmp_path / "fleet").read().keys.values()
    assert FleetRoles(tmp_path / "fleet").at(key.name, "robot1", "operator") is None


@pytest.mark.campaign
def test_three_robots_run_as_the_page_says_and_share_a_map(tmp_path: Path) -> None:
    ports = {old: str(free_port()) for old in ("7447", "8430", "8421", "8422", "8423")}
    makes, serves, runs, shares = (
        re.sub("|".join(ports), lambda found: ports[found[0]], fence) for fence in fences("run-three-robots")
    )
    (tmp_path / "bin").mkdir()
    beckon = tmp_path / "bin" / "beckon"
    beckon.write_text(f'#!/bin/sh\nexec {sys.executable} -m console "$@"\n')
    beckon.chmod(0o700)
    path = f"{beckon.parent}:{os.environ['PATH']}"
    more = {"BECKON_HOME": str(tmp_path / "home"), "PYTHONPATH": str(ROOT), "PATH": path}
    settled: dict[str, Any] = {"cwd": tmp_path, "env": {**os.environ, **more}}
    subprocess.run(["bash", "-ec", makes], check=True, timeout=START_TIME_S, **settled)
    listen = f"--listen tls/127.0.0.1:{ports['7447']} --port {ports['8430']}"
    lines = [f"{serves.strip()} {listen}", *runs.splitlines()]
    with contextlib.ExitStack() as stack:
        for line in lines:
            stack.enter_context(started(f"{line} --no-browser", settled))
        first, _, rest = shares.partition("\n")
        said = subprocess.run(
            ["bash", "-ec", f"{first}; echo $KEY"], check=True, capture_output=True, text=True, **settled
        )
        token = said.stdout.split()[-1]

        def links() -> list[str]:
            return [one["link"] for one in state(int(ports["8430"]), token).get("robots", [])]

        until(lambda: links() == ["live"] * 3, START_TIME_S)
        subprocess.run(["bash", "-ec", f"KEY={token}\n{rest}"], check=True, timeout=START_TIME_S, **settled)
        until(lambda: sum(bool(one) for one in maps(int(ports["8430"]), token)) == 2, START_TIME_S)
        assert len(set(filter(None, maps(int(ports["8430"]), token)))) == 1, "both go on in one map"


@contextlib.contextmanager
def started(line: str, settled: dict[str, Any]) -> Iterator[None]:
    process = subprocess.Popen(["bash", "-c", f"exec {line}"], stdout=subprocess.DEVNULL, **settled)
    try:
        yield
    finally:
        process.terminate()
        process.wait(60)


def state(port: int, token: str) -> dict[str, Any]:
    line = http.client.HTTPConnection("127.0.0.1", port, timeout=30)
    with contextlib.suppress(OSError):
        line.request("GET", "/api/fleet", headers={"Authorization": f"Bearer {token}"})
        return json.loads(line.getresponse().read())
    return {}


def maps(port: int, token: str) -> list[str]:
    return [(one["map"] or {}).get("id", "") for one in state(port, token).get("robots", [])]
