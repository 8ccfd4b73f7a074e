"""The first minute on a busy computer: `python -m tests.benchmarks.first_minute [--newcomers 10] [--calls 20]`.

Beside two programs that use all of two processors. Newcomers: a fresh console and a fresh browser each; by mouse they
press *turn left* and then click on the floor; both must be done. Calls: in the first second of a fresh console
someone in the simulated room says a command; it must be obeyed, though the recognizer is just starting.
"""

import json
import multiprocessing
import os
import tempfile
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from playwright.sync_api import Page, expect, sync_playwright

from tests.benchmarks.command import print_row, run_command
from tests.browser import running_console, visit
from tests.browser.conftest import chromium_path
from tests.browser.running_console import Running
from tests.browser.visit import FLAT, Profiles, Visit

PATIENCE_S = 1800.0  # of a computer that does everything else meanwhile: a robot's second may take it a minute
SAYINGS = ("turn left", "turn right", "come here", "follow wall", "continue 1 meter")


@contextmanager
def busy_programs(count: int) -> Generator[None]:
    """So many programs that use a processor each."""
    programs = [multiprocessing.Process(target=_busy, daemon=True) for _ in range(count)]
    for program in programs:
        program.start()
    try:
        yield
    finally:
        for program in programs:
            program.kill()


def _busy() -> None:
    while True:
        pass


@contextmanager
def fresh_console() -> Generator[Running]:
    """A console as a newcomer starts it, with an empty data folder."""
    running_console.START_TIME, running_console.ANSWER_S = PATIENCE_S, PATIENCE_S
    with tempfile.TemporaryDirectory() as folder, Running(Path(folder), people=True, precedence=False) as running:
        yield running


def ended(running: Running, fits: Callable[[dict[str, Any]], bool], poll: Callable[[float], None]) -> dict[str, Any]:
    """The command that fits, when it has ended; {} where it never came or does not end."""
    begun, found = time.monotonic(), {}
    while time.monotonic() - begun < PATIENCE_S:
        rows = running.ask("api/commands/history")["commands"]
        found = next((row for row in rows if fits(row)), {})
        if found and found["state"] != "running":
            return found
        poll(0.2)
    return {**found, "remark": f"not ended within {PATIENCE_S:g} s"} if found else {}


def row_of(order: str, row: dict[str, Any], seconds: float, running: Running) -> dict[str, Any]:
    pace = running.ask("api/state")["robot"]["pace"]
    return {
        "order": order,
        "state": row.get("state", "never came"),
        "remark": row.get("remark", ""),
        "seconds": round(seconds, 1),
        "pace": pace,
        "load": round(os.getloadavg()[0], 1),
    }


def newcomer(profiles: Profiles) -> list[dict[str, Any]]:
    """One newcomer's first two orders, by mouse."""
    told: list[dict[str, Any]] = []
    with fresh_console() as running:
        here = Visit(profiles, running, hints=True, before=open_patiently)
        for order, press, fits in (
            ("turn left", lambda: here.find('[data-command="turn_left"]').click(), is_chip),
            ("floor", lambda: click_floor(here), is_click),
        ):
            begun = time.monotonic()
            press()
            row = ended(running, fits, here.wait)
            told.append(row_of(order, row, time.monotonic() - begun, running))
        here.close()
    return told


def open_patiently(page: Page) -> None:
    """Wait for this page as long as it takes; its map is the flat one."""
    page.set_default_timeout(1000 * PATIENCE_S)
    page.add_init_script("localStorage.setItem('beckon.map', 'flat')")


def is_chip(row: dict[str, Any]) -> bool:
    """Whether a row of the history is of a pressed button."""
    return row["source"] == "chip"


def is_click(row: dict[str, Any]) -> bool:
    """Whether a row of the history is of a click on the map."""
    return row["source"] == "click"


def click_floor(here: Visit) -> None:
    """Click beside the middle of the map, where the robot is at first: on free floor, not under the hints."""
    floor = here.find(".flat-floor")
    expect(floor).to_be_visible(timeout=1000 * PATIENCE_S)
    box = floor.bounding_box()
    assert box is not None
    here.page.mouse.click(box["x"] + 0.5 * box["width"] + 60, box["y"] + 0.5 * box["height"] + 40)


def call(number: int) -> dict[str, Any]:
    """One sentence in the first second of a console, from Ann."""
    text = SAYINGS[number % len(SAYINGS)]
    with fresh_console() as running:
        running.ask("api/hearing", {"listen": True, "obey": True})
        begun = time.monotonic()
        running.ask("api/sim/say", {"id": "Ann", "text": text})
        heard: dict[str, Any] = {}
        while time.monotonic() - begun < PATIENCE_S and not heard:
            time.sleep(0.2)
            rows = running.ask("api/commands/history")["commands"]
            heard = next((row for row in rows if row["source"] == "ears" and row["words"]), {})
        return row_of(text, heard, time.monotonic() - begun, running)


def understood(row: dict[str, Any]) -> bool:
    """Whether the robot obeyed what was said: what became of the way is not asked here."""
    return row["state"] not in ("refused", "never came")


def main(
    *,
    newcomers: int = 10,
    calls: int = 20,
    busy: int = 2,  # programs beside
) -> None:
    visit.PATIENCE = PATIENCE_S
    with busy_programs(busy):
        obeyed = []
        for number in range(calls):
            obeyed.append(call(number))
            print_row(f"call {number + 1}: {json.dumps(obeyed[-1])}")
        done = 0
        if newcomers:
            with sync_playwright() as playwright:
                browser = playwright.chromium.launch(
                    executable_path=chromium_path(playwright), args=[*FLAT, "--no-sandbox"]
                )
                for number in range(newcomers):
                    orders = newcomer(Profiles(browser))
                    done += all(one["state"] == "done" for one in orders)
                    print_row(f"newcomer {number + 1}: {json.dumps(orders)}")
    right = sum(understood(one) for one in obeyed)
    print_row(f"first calls understood {right} of {calls}; newcomers done {done} of {newcomers}")


if __name__ == "__main__":
    run_command(main)
