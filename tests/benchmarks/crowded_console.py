"""Two operators and three viewers at one console: `python -m tests.benchmarks.crowded_console [--minutes 10]`.

Five Chromium profiles. By turns, drawn from the seed: commands, driving by hand, taking over, asking for control and
being given it, a viewer's STOP, reloads, links that are cut, pages that leave and come back, and twice the console is
killed and started anew on its data. Ten times a second the robot's speed and who drives are noted from outside.
Printed: what moved while nobody drove, who did not come back within 20 s, and how the history differs from what was
said.
"""

import contextlib
import random
import socket
import tempfile
import threading
import time
from collections import Counter
from pathlib import Path

from playwright.sync_api import Browser, Locator, Page, WebSocketRoute, expect, sync_playwright

from tests.benchmarks.command import print_row, run_command
from tests.browser.conftest import chromium_path
from tests.browser.running_console import Running
from tests.browser.visit import FLAT, NO_SCENE

BACK_IN = 20.0  # [s] within which everybody is back
MOVES = 0.02  # [m/s], or a third of it [rad/s] times 0.1 m
GRACE = 0.5  # [s] that a robot may take to stand after who drove has gone
PERIOD = 0.1  # [s]
WORDS = ("turn left", "turn right", "continue 0.2 meters", "stop moving", "come here")


class Visitor:
    """One person: a profile of the browser, an operator's or a viewer's page."""

    def __init__(self, browser: Browser, name: str, watches: bool, console: Running) -> None:
        self.name, self.watches = name, watches
        self.context = browser.new_context(viewport={"width": 1280, "height": 720}, reduced_motion="reduce")
        self.context.add_init_script("localStorage.setItem('beckon.hints', 'seen')")
        self.links: list[WebSocketRoute] = []
        self.page = self._open(console.watching if watches else console.driving)
        self.address = console.url

    def _open(self, address: str) -> Page:
        page = self.context.new_page()
        page.add_init_script(NO_SCENE)
        page.route_web_socket("**/ws", self._link)
        page.goto(address)
        return page

    def _link(self, link: WebSocketRoute) -> None:
        link.connect_to_server()
        self.links.append(link)

    def find(self, what: str) -> Locator:
        return self.page.locator(what)

    def button(self, name: str) -> Locator:
        return self.page.get_by_role("button", name=name, exact=True)

    def cut(self) -> None:
        """Lose the link; the page looks for it anew."""
        links, self.links = self.links, []
        for link in links:
            link.close(code=4000, reason="cut")

    def leave_and_return(self) -> None:
        """Another page for two seconds."""
        self.page.goto("about:blank")
        self.page.wait_for_timeout(2000)
        self.page.goto(self.address)

    def say(self, words: str) -> None:
        self.find("#words").fill(words)
        self.page.keyboard.press("Enter")

    def take_over(self) -> None:
        """Control, whoever has it."""
        self.find("lease-chip button").first.click()
        for name in ("Take over", "Take control"):
            button = self.find("lease-chip").get_by_role("button", name=name)  # a refusal has one, too
            if button.is_visible():
                button.click()
                return
        self.page.keyboard.press("Escape")

    def ask(self) -> None:
        self.find("lease-chip button").first.click()
        if self.button("Ask for control").first.is_visible():
            self.button("Ask for control").first.click()
        self.find("lease-chip button").first.click()

    def is_back(self) -> bool:
        return "Hz" in self.find("link-chip").inner_text() and not self.find("login-view").is_visible()


class Watch(threading.Thread):
    """Who drives and how fast the robot is, ten times a second."""

    def __init__(self, console: Running) -> None:
        super().__init__(daemon=True)
        self.console = console
        self.over = False
        self.looks = self.moving = 0
        self.alone: list[float] = []  # [s] for which it moved while nobody drove
        self._since: float | None = None

    def run(self) -> None:
        while not self.over:
            with contextlib.suppress(OSError, AssertionError, ValueError):
                state = self.console.ask("api/state")
                moves = abs(state["velocity"]["v_m_s"]) > MOVES or abs(state["velocity"]["w_rad_s"]) > 3 * MOVES
                self.looks += 1
                self.moving += moves
                now = time.monotonic()
                if not moves or state["lease"]["holder"] is not None:
                    if self._since is not None and now - self._since > GRACE:
                        self.alone.append(now - self._since)
                    self._since = None
                elif self._since is None:
                    self._since = now
            time.sleep(PERIOD)


class Crowd:
    """Five people, one console."""

    def __init__(self, browser: Browser, folder: Path, seed: int) -> None:
        self.folder, self.draw = folder, random.Random(seed)
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.console = self._start()
        self.operators = [Visitor(browser, name, False, self.console) for name in ("first", "second")]
        self.viewers = [Visitor(browser, name, True, self.console) for name in ("third", "fourth", "fifth")]
        self.everybody = [*self.operators, *self.viewers]
        self.watch = Watch(self.console)
        self.said: list[str] = []
        self.missing: list[str] = []
        self.slowest = 0.0
        self.done: Counter[str] = Counter()

    def _start(self) -> Running:
        return Running(self.folder, "--port", str(self.port)).__enter__()

    def restart(self) -> None:
        """Kill it and start it anew on its data."""
        self.console._process.kill()
        self.console._process.wait()
        self.console = self.watch.console = self._start()

    def command(self) -> None:
        """A person who operates says something."""
        who, words = self.draw.choice(self.operators), self.draw.choice(WORDS)
        who.say(words)
        self.said.append(words)

    def by_hand(self) -> None:
        """A person who operates holds W."""
        page = self.draw.choice(self.operators).page
        page.locator("link-chip").click(trial=True)
        page.evaluate("document.activeElement?.blur()")
        page.keyboard.down("w")
        page.wait_for_timeout(1200)
        page.keyboard.up("w")

    def hand_over(self) -> None:
        """One asks, the other gives."""
        asks, gives = self.draw.sample(self.operators, 2)
        asks.ask()
        with contextlib.suppress(Exception):  # who asked drives already, or nobody does
            gives.button("Give control").click(timeout=3000)

    def someone(self, act: str) -> None:
        """A page is loaded anew, loses its link, or leaves."""
        who = self.draw.choice(self.everybody)
        {"reload": who.page.reload, "cut": who.cut, "leave": who.leave_and_return}[act]()

    def turn(self, act: str) -> None:
        """One event, and the wait until everybody is back."""
        self.done[act] += 1
        if act == "command":
            self.command()
        elif act == "by hand":
            self.by_hand()
        elif act == "take over":
            self.draw.choice(self.operators).take_over()
        elif act == "hand over":
            self.hand_over()
        elif act == "viewer stops":
            self.draw.choice(self.viewers).page.keyboard.press("Escape")
        elif act == "restart":
            self.restart()
        else:
            self.someone(act)
        begun = time.monotonic()
        for who in self.everybody:
            while not who.is_back() and time.monotonic() - begun < BACK_IN:
                who.page.wait_for_timeout(100)
            if not who.is_back():
                self.missing.append(f"{who.name} after {act}")
        self.slowest = max(self.slowest, time.monotonic() - begun)

    def live(self, minutes: float) -> None:
        acts = ["command"] * 5 + ["by hand", "take over", "hand over", "viewer stops", "reload", "cut", "leave"]
        end, restarts = time.monotonic() + 60 * minutes, [1 / 3, 2 / 3]
        self.watch.start()
        while (left := end - time.monotonic()) > 0:
            due = bool(restarts) and 1 - left / (60 * minutes) > restarts[0]
            self.turn("restart" if due and restarts.pop(0) else self.draw.choice(acts))
            self.everybody[0].page.wait_for_timeout(500 + 2000 * self.draw.random())
        self.watch.over = True

    def ends_well(self) -> list[str]:
        """At the end each operator can drive, and each viewer sees it and can stop it."""
        faults: list[str] = []
        for who in self.operators:
            who.take_over()
            before = self.console.newest()["id"]
            who.say("turn left")
            self.said.append("turn left")
            until = time.monotonic() + 15
            while (row := self.console.newest())["id"] <= before or row["state"] == "running":
                who.page.wait_for_timeout(100)
                if time.monotonic() > until:
                    break
            if row["state"] != "done":
                faults.append(f"{who.name} cannot drive: {row}")
        for who in self.viewers:
            expect(who.find("command-status")).to_be_visible()
            if who.find("#words").is_enabled() and not who.find('[data-command="turn_left"]').is_disabled():
                faults.append(f"{who.name} could give commands")
        return faults


def main(*, minutes: float = 10.0, seed: int = 1) -> int:
    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as folder:
        browser = playwright.chromium.launch(executable_path=chromium_path(playwright), args=[*FLAT, "--no-sandbox"])
        crowd = Crowd(browser, Path(folder), seed)
        try:
            crowd.live(minutes)
            faults = crowd.ends_well()
            rows = crowd.console.ask("api/commands/history")["commands"]
        finally:
            crowd.watch.over = True
            crowd.console.__exit__(None, None, None)
    heard = [row["words"] for row in reversed(rows) if row["source"] == "typed"]
    lost = Counter(crowd.said) - Counter(heard)
    watch = crowd.watch
    lines = (
        f"events: {dict(crowd.done)}",
        f"looks at the robot: {watch.looks}, while it moved {watch.moving}",
        f"moved more than {GRACE} s while nobody drove: {len(watch.alone)} {watch.alone}",
        f"not back within {BACK_IN:.0f} s: {len(crowd.missing)} {crowd.missing}; slowest {crowd.slowest:.1f} s",
        f"said {len(crowd.said)}, in the history {len(heard)}; missing there: {dict(lost)}",
        f"endings: {dict(Counter(row['state'] for row in rows))}",
        f"at the end: {faults or 'all can drive and watch'}",
    )
    print_row("\n".join(lines))
    return int(bool(crowd.watch.alone or crowd.missing or faults or lost))


if __name__ == "__main__":
    run_command(main)
