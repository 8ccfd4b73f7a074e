"""How long FOLLOW WALL outlives its owner: `python -m tests.benchmarks.lost_owner [--trials 3] [--only WORD]`.

The owner's page hangs (its main thread in a busy loop), its browser is frozen or killed, or the program that ordered
by REST is gone. The time runs from that moment to the gate's last motion, both by this program's clock: a simulated
robot's gate has that of the simulator.
"""

import contextlib
import shutil
import statistics
import time
from collections.abc import Callable

import psutil
from playwright.sync_api import Page, sync_playwright

from tests.benchmarks.command import print_row, run_command
from tests.benchmarks.running_console import Console, console
from tests.campaign.struck import TraceOnlooker, moving, until

PATIENCE = 25.0  # [s] after which it goes on for ever
STANDS_S = 2.0  # without motion after which it stands for good
BUSY = "() => { setTimeout(() => { for (;;); }, 0); }"


def until_awake(running: Console) -> None:
    """The robot has looked around."""
    while running.get("/api/health")["reasons"] or running.get("/api/state")["slam"]["looking_around"]:
        time.sleep(0.2)


def browsers() -> list[psutil.Process]:
    """The processes of the Chromium that this one started."""
    return [one for one in psutil.Process().children(recursive=True) if "chrom" in one.name().lower()]


def hangs(page: Page) -> None:
    """Its main thread never comes back."""
    page.evaluate(BUSY)


def frozen(page: Page) -> None:
    for one in browsers():
        one.suspend()


def killed(page: Page) -> None:
    for one in browsers():
        with contextlib.suppress(psutil.NoSuchProcess):
            one.kill()


def zero_after(onlooker: TraceOnlooker, struck: int) -> float:
    """[s] from `struck`, monotonic [ns], to standstill; inf where it goes on."""
    while (now := time.monotonic_ns()) < struck + PATIENCE * 1e9:
        moved = onlooker.last_motion
        if now - max(moved, struck) > STANDS_S * 1e9:
            return max(0.0, moved - struck) * 1e-9
        time.sleep(0.1)
    return float("inf")


def by_page(strike: Callable[[Page], None]) -> float:
    """One trial with a page of its own, in a browser of its own."""
    with console() as running, sync_playwright() as playwright:
        until_awake(running)
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--disable-gpu", "--no-sandbox"]
        )
        page = browser.new_page()
        page.route("**/scene/**", lambda route: route.fulfill(body="", content_type="text/html"))
        page.set_default_timeout(60_000)
        page.goto(f"http://127.0.0.1:{running.port}/")
        page.wait_for_selector("link-chip:has-text('Hz')")
        page.fill("#words", "follow wall")
        page.keyboard.press("Enter")
        until(lambda: moving(running.trace), 20.0)
        time.sleep(3.0)
        try:
            with TraceOnlooker(running.trace) as onlooker:
                struck = time.monotonic_ns()
                strike(page)
                return zero_after(onlooker, struck)
        finally:
            killed(page)
            for one in browsers():
                one.resume()


def by_rest() -> float:
    """One trial with a program that is gone after its order."""
    with console() as running:
        until_awake(running)
        with TraceOnlooker(running.trace) as onlooker:
            struck = time.monotonic_ns()
            running.post("/api/commands", {"text": "follow wall"})
            until(lambda: moving(running.trace), 20.0)
            return zero_after(onlooker, struck)


TRIALS: dict[str, Callable[[], float]] = {
    "page hangs": lambda: by_page(hangs),
    "browser frozen": lambda: by_page(frozen),
    "browser killed": lambda: by_page(killed),
    "program gone": by_rest,
}


def main(*, trials: int = 3, only: str = "") -> None:
    for name, trial in TRIALS.items():
        if only in name:
            found = sorted(round(trial(), 2) for _ in range(trials))
            told = {"lost": name, "median_s": statistics.median(found), "max_s": found[-1], "all_s": found}
            print_row(told)


if __name__ == "__main__":
    run_command(main)
