"""What a console and its page cost: `python -m tests.benchmarks.page_costs [--seconds 20]`.

A console on the simulator as a newcomer starts it, with its people. Printed as JSON: seconds until the address stands
in the terminal and until the page can be used, the page's weight, its sockets' bytes a second while the robot stands
and drives, processor time (share of one core, all processes of the console, the browser's not counted) with nobody
looking, with a viewer and while driving, and the memory of all processes at rest and after spoken words. Chromium
shows the flat map.
"""

import os
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import psutil
from playwright.sync_api import CDPSession, Page, expect, sync_playwright

from tests.benchmarks.command import run_command
from tests.browser.conftest import chromium_path
from tests.browser.running_console import Running
from tests.browser.visit import FLAT

SETTLED = 8.0  # [s] after the start until nothing is loaded any more
TO_AND_FRO = ("turn left", "turn right")


class Traffic:
    """Bytes that a page gets: files, and messages of its sockets."""

    def __init__(self, session: CDPSession) -> None:
        self.files = self.messages = 0
        session.on("Network.loadingFinished", lambda event: self._add_file(event["encodedDataLength"]))
        session.on("Network.webSocketFrameReceived", lambda event: self._add_message(event["response"]))
        session.send("Network.enable")

    def _add_file(self, size: float) -> None:
        self.files += int(size)

    def _add_message(self, message: dict[str, Any]) -> None:
        text = message["payloadData"]
        self.messages += len(text) * 3 // 4 if message["opcode"] == 2 else len(text.encode())


class Processes:
    """A console and all that it started."""

    def __init__(self, number: int) -> None:
        self._console = psutil.Process(number)

    @property
    def _all(self) -> list[psutil.Process]:
        return [self._console, *self._console.children(recursive=True)]

    def memory(self) -> float:
        """[MB], what they share counted once."""
        return sum(one.memory_full_info().pss for one in self._all) / 1e6

    def spent(self) -> float:
        """[s] of a processor."""
        return sum(sum(one.cpu_times()[:2]) for one in self._all)


def rates(
    processes: Processes, traffic: Traffic | None, seconds: float, wait: Callable[[], None]
) -> dict[str, float]:
    """Share of a core and bytes a second over some time, during which `wait` is called again and again."""
    spent, came, began = processes.spent(), traffic.messages if traffic else 0, time.monotonic()
    while time.monotonic() < began + seconds:
        wait()
    passed = time.monotonic() - began
    found = {"core_percent": round(100 * (processes.spent() - spent) / passed, 1)}
    if traffic is not None:
        found["kilobytes_per_s"] = round((traffic.messages - came) / passed / 1e3, 1)
    return found


def drive(page: Page, running: Running) -> Callable[[], None]:
    """Turn to and fro."""
    number = 0

    def wait() -> None:
        nonlocal number
        running.ask("api/commands", {"text": TO_AND_FRO[number % 2]})
        number += 1
        page.wait_for_timeout(4500)

    return wait


def measured(seconds: float) -> dict[str, Any]:
    """All of it, once."""
    report: dict[str, Any] = {"load_of_the_machine": round(os.getloadavg()[0], 1)}
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        began = time.monotonic()
        running = Running(Path(folder), people=True, precedence=False)
        with running:
            report["address_s"] = round(running.linked_at - began, 2)
            processes = Processes(running.pid)
            time.sleep(SETTLED)
            report["nobody_looks"] = rates(processes, None, seconds, lambda: time.sleep(0.5))
            report["memory_at_rest_mb"] = round(processes.memory())
            caged = ["--no-sandbox"] if os.geteuid() == 0 else []
            browser = playwright.chromium.launch(executable_path=chromium_path(playwright), args=[*FLAT, *caged])
            page = browser.new_page(viewport={"width": 1440, "height": 900})
            page.add_init_script("localStorage.setItem('beckon.hints', 'seen')")
            page.add_init_script("localStorage.setItem('beckon.map', 'flat')")
            traffic = Traffic(page.context.new_cdp_session(page))
            opened = time.monotonic()
            page.goto(running.driving)
            expect(page.locator('[data-command="turn_left"]')).to_be_enabled(timeout=30_000)
            report["page_usable_s"] = round(time.monotonic() - opened, 2)
            page.wait_for_timeout(5000)
            report["page_kilobytes"] = round(traffic.files / 1e3)
            report["a_viewer"] = rates(processes, traffic, seconds, lambda: page.wait_for_timeout(500))
            report["driving"] = rates(processes, traffic, seconds, drive(page, running))
            running.ask("api/sim/say", {"text": "turn left", "id": "Ann"})
            page.wait_for_timeout(6000)
            report["memory_driving_and_listening_mb"] = round(processes.memory())
            browser.close()
    return report


def main(*, seconds: float = 20.0) -> object:
    return measured(seconds)


if __name__ == "__main__":
    run_command(main)
