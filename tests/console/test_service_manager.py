"""Word to the service manager, log lines as JSON, and the files that come with the documentation."""

import asyncio
import configparser
import json
import logging
import re
import socket
from pathlib import Path

import pytest

from console.cli import build_parser
from console.logging_setup import JsonFormatter
from console.service_manager import ServiceManagerWatchdog, notify

SERVICE = Path(__file__).parents[2] / "static/docs/service"


@pytest.fixture
def listening(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> socket.socket:
    line = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    line.bind(str(tmp_path / "notify"))
    line.setblocking(False)
    monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "notify"))
    return line


def heard(line: socket.socket) -> list[bytes]:
    words: list[bytes] = []
    while True:
        try:
            words.append(line.recv(100))
        except BlockingIOError:
            return words


def test_the_service_manager_hears_that_it_is_ready_lives_and_ends(
    listening: socket.socket, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("WATCHDOG_USEC", "20000000")
    notify("READY=1")
    watchdog = ServiceManagerWatchdog()
    for tick in range(200):  # ten seconds
        watchdog.tick(1000.0 + 0.05 * tick)
    asyncio.run(watchdog.close())
    assert heard(listening) == [b"READY=1", b"WATCHDOG=1", b"WATCHDOG=1", b"STOPPING=1"]


def test_without_a_service_manager_or_when_it_is_gone_nothing_happens(
    listening: socket.socket, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.delenv("WATCHDOG_USEC", raising=False)
    ServiceManagerWatchdog().tick(0.0)
    assert heard(listening) == []
    for address in ("", str(tmp_path / "nobody"), "@beckon-nobody-listens"):
        monkeypatch.setenv("NOTIFY_SOCKET", address)
        notify("READY=1")
    assert heard(listening) == []


def test_a_line_of_the_log_is_a_json_object_with_its_traceback() -> None:
    try:
        raise ValueError('a "quoted"\nvalue')
    except ValueError as trouble:
        record = logging.LogRecord("a", 40, "f", 1, "It failed (%s).", ("ü",), (ValueError, trouble, None))
    line = JsonFormatter().format(record)
    told = json.loads(line)
    assert "\n" not in line and told["message"] == "It failed (ü)." and told["level"] == "ERROR"
    assert "ValueError" in told["traceback"] and re.fullmatch(r"[\d-]{10}T[\d:]{8}\.\d{3}Z", told["time"])


def test_the_unit_starts_what_the_command_line_understands_and_keeps_keys_out_of_the_journal() -> None:
    unit = configparser.ConfigParser(strict=False, interpolation=None)
    unit.read(SERVICE / "beckon.service")
    service = unit["Service"]
    build_parser().parse_args(service["ExecStart"].split()[1:])
    assert service["Type"] == "notify" and service["StandardOutput"] == "null"


def test_the_dashboard_asks_for_figures_that_there_are() -> None:
    source = (Path(__file__).parents[2] / "console/api/state.py").read_text()
    panels = json.loads((SERVICE / "grafana.json").read_text())["panels"]
    asked = {
        name for panel in panels for one in panel["targets"] for name in re.findall(r"beckon_(\w+)", one["expr"])
    }
    assert len(panels) == 8 and all(f'"{name}"' in source for name in asked)
