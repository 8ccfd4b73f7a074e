"""One person at one page: how it is opened, what is done on it, and what it complains about."""

import contextlib
import re
import time
from collections.abc import Callable
from typing import Any

from playwright.sync_api import Browser, BrowserContext, ConsoleMessage, Error, Locator, Page, Response, expect
from playwright.sync_api import TimeoutError as NotThere

from tests.browser.running_console import Running

IN_PROCESS = "--enable-features=NetworkServiceInProcess2"  # or every file of a page goes through one process more
NO_OMNIBOX = (  # 350 files a window that nobody looks at; the first four are of Playwright, as far as they matter
    "--disable-features=DestroyProfileOnBrowserClose,HttpsUpgrades,OptimizationHints,PaintHolding,"
    "WebUIOmniboxPopup,WebUIOmniboxAimPopup,WebUIOmniboxFullPopup,PreloadTopChromeWebUI"
)
FLAT = ["--disable-gpu", IN_PROCESS, NO_OMNIBOX]  # what Chromium is started with where nobody looks at the 3-D map …
WITH_SCENE = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"]  # … and where someone does
DESK, PHONE = (1440, 900), (390, 844)
HARMLESS = ("Software WebGL", "GPU stall", "GL Driver Message", "401 (Unauthorized)", "THREE.Clock")
PATIENCE = 45.0  # [s]; the machine may be busy
MAX_SLOWNESS, PRESS_S = 4.0, 5.0  # of the robot's clock; [s] after which a press that does nothing is made anew
expect.set_options(timeout=PATIENCE * 1000)


NO_SCENE = """
    const { get, set } = Object.getOwnPropertyDescriptor(HTMLIFrameElement.prototype, "src");
    const NOWHERE = "about:blank?";
    Object.defineProperty(HTMLIFrameElement.prototype, "src", {
        get() { return get.call(this).replace(NOWHERE, ""); },
        set(url) { set.call(this, url.includes("/scene/") && !window.sceneIsShown ? NOWHERE + url : url); },
    });
"""
"""Nothing instead of the 3-D map. A route would do it, but a page with routes keeps no file."""


class Profiles:
    """A browser's profiles. One that was left is wiped but for its cache and used again: half a page's cost."""

    def __init__(self, browser: Browser) -> None:
        self.browser = browser
        self._left: dict[tuple[tuple[int, int], str], list[BrowserContext]] = {}

    def take(self, size: tuple[int, int], theme: str) -> BrowserContext:
        """A profile that nobody uses, with this size of its window."""
        left = self._left.get((size, theme))
        if left:
            return left.pop()
        phone = size[0] < 600
        return self.browser.new_context(
            viewport={"width": size[0], "height": size[1]},
            color_scheme=theme,  # type: ignore[arg-type]
            has_touch=phone,
            is_mobile=phone,
            device_scale_factor=2 if phone else 1,
            reduced_motion="reduce",
        )

    def leave(self, page: Page, size: tuple[int, int], theme: str) -> None:
        """Close the page, and wipe what it kept."""
        page.goto("about:blank")
        context = page.context
        context.new_cdp_session(page).send(
            "Storage.clearDataForOrigin", {"origin": "*", "storageTypes": "cookies,local_storage,indexeddb"}
        )
        for one in context.pages:
            one.close()
        self._left.setdefault((size, theme), []).append(context)


class Visit:
    """A page in a profile of its own, signed in and linked."""

    def __init__(
        self,
        profiles: Profiles,
        console: Running,
        *,
        size: tuple[int, int] = DESK,
        theme: str = "dark",
        hints: bool = False,
        watching: bool = False,
        before: Callable[[Any], None] | None = None,
        at: str = "",
    ) -> None:
        """`hints`: as on a first visit; `before`: done to the page before it opens; `at`: the path that is opened."""
        self.console = console
        self._profiles, self._kind = profiles, (size, theme)
        self.complaints: list[str] = []
        self.page = profiles.take(size, theme).new_page()
        self._refusals: list[Response] = []
        self.page.on("console", self._note)
        self.page.on("response", lambda answer: answer.status >= 400 and self._refusals.append(answer))
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        if not hints:
            self.page.add_init_script("localStorage.setItem('beckon.hints', 'seen')")
        self.page.add_init_script(NO_SCENE)
        if before is not None:
            before(self.page)
        self.page.goto((console.watching if watching else console.driving).replace("#", f"{at}#"))
        expect(self.page.locator("link-chip")).to_contain_text("Hz", timeout=PATIENCE * 1000)

    def show_scene(self, *, coarse: bool = False) -> None:
        """Load the 3-D map that was left out until now: a processor that draws it does little else.

        `coarse`: with few picture elements, where only what is behind them matters.
        """
        self.button("3-D").click()  # whoever chose it keeps it, however slow it is
        self.page.evaluate("sceneIsShown = true")
        more = "&fixedDpr=0.25" if coarse else ""
        self.page.evaluate("more => { const frame = document.querySelector('#scene'); frame.src += more }", more)
        canvas = self.page.frame_locator("#scene").locator("canvas").first
        expect(canvas).to_be_visible(timeout=2000 * PATIENCE)
        expect(canvas).to_have_css("opacity", "1", timeout=2000 * PATIENCE)  # it fades in

    def fresh(self) -> None:
        """Wait until the page shows what is now."""
        stale = self.find("link-chip [data-tone], .camera-empty:visible, camera-view.is-old")
        self.until(lambda: stale.count() == 0, "the page is up to date", 4 * PATIENCE)

    def close(self) -> None:
        self._profiles.leave(self.page, *self._kind)

    def find(self, what: str) -> Locator:
        """A part of the page."""
        return self.page.locator(what)

    def button(self, name: str) -> Locator:
        return self.page.get_by_role("button", name=name, exact=True)

    def go(self, path: str) -> None:
        """Follow the menu's link to a page of the console; no document is loaded."""
        self.find(f"page-menu a[href='{path or './'}']").dispatch_event("click")
        expect(self.find("body")).to_have_attribute("data-page", path or "drive")

    def open_tab(self, name: str) -> None:
        """Open a tab of the details; where one view is shown at a time, those first."""
        if self.button("Details").is_visible():
            self.button("Details").click()
        self.page.get_by_role("tab", name=re.compile(rf"^{name}\b")).click()  # a number may follow: notices unseen

    def say(self, words: str) -> None:
        """Type words and send them."""
        self.find("#words").fill(words)
        self.page.keyboard.press("Enter")

    def wait(self, seconds: float) -> None:
        """Let time pass, the page's too."""
        self.page.wait_for_timeout(seconds * 1000)

    def laid_out(self) -> None:
        """Wait until the page was drawn as it is now."""
        self.page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")

    def until(self, is_so: Callable[[], Any], what: str, patience: float = PATIENCE) -> float:
        """Wait until it is so → how long it took [s]."""
        begun = time.monotonic()
        while not is_so():
            assert time.monotonic() - begun < patience, f"waited {patience} s in vain: {what}"
            self.wait(0.05)
        return time.monotonic() - begun

    def within(self, seconds: float, is_so: Callable[[], Any], what: str) -> None:
        """Wait until it is so, which may take `seconds` of the robot's clock: it waits for a slow computer."""
        begun = self.console.stamp()

        def seen() -> bool:
            """Ask once: wheels that come to rest swing a little, and a second reading may refuse the first."""
            if is_so():
                return True
            assert self.console.stamp() - begun <= seconds, f"not within {seconds} s: {what}"
            return False

        self.until(seen, what)

    def hold(self, key: str, is_so: Callable[[], Any], what: str) -> None:
        """Hold a key until it is so; the key stays down."""
        keyboard = self.page.keyboard
        self.insist(lambda: keyboard.down(key), lambda: keyboard.up(key), is_so, what)

    def insist(
        self, press: Callable[[], Any], let_go: Callable[[], Any], is_so: Callable[[], Any], what: str
    ) -> None:
        """Press until it is so; after a trip (a busy machine has them), or in vain, press anew, as a person would.

        What it may take counts by the robot's clock, which waits for a slow computer.
        """
        begun, robot = time.monotonic(), self.console.stamp()
        pressed = begun
        press()
        while not is_so():
            waited = max(self.console.stamp() - robot, (time.monotonic() - begun) / MAX_SLOWNESS)
            assert waited < 2 * PATIENCE, f"in vain: {what}. {self.find('.drive-why').inner_text()}"
            if self.find(".drive-why[data-tone]").count() or time.monotonic() - pressed > PRESS_S:
                let_go()
                self.wait(0.1)
                press()
                pressed = time.monotonic()
            self.wait(0.05)

    def told(self, act: Callable[[], Any], end: str, *, then: Callable[[], Any] | None = None) -> dict[str, Any]:
        """Tell the robot something, do `then` while it runs → how it ended, which must be `end`.

        The gate of a busy machine stops the robot now and then, or `then` comes when it is over; then it is told
        again, as a person would.
        """
        row: dict[str, Any] = {}
        lease = self.find(".lease-text")
        self.until(lambda: lease.inner_text() in ("You drive", "Nobody drives"), "control is free", 4 * PATIENCE)
        for _ in range(8):
            before = self.console.newest()["id"]
            act()
            self.until(lambda before=before: self.console.newest()["id"] > before, "it was heard")
            if then is not None:
                with contextlib.suppress(NotThere):  # what it was to press has gone again
                    then()
            self.until(lambda: self.console.newest()["state"] != "running", "it ended", 2 * PATIENCE)
            row = self.console.newest()
            if row["state"] == end or row["state"] not in ("failed", "done"):
                break
        assert row["state"] == end, row
        return row

    def still(self) -> None:
        """Wait until the robot stands, in several readings: an order given a moment ago may not show in the first."""
        stood = 0

        def stands() -> bool:
            nonlocal stood
            moves = max(abs(self.console.speed()), abs(self.console.turning())) >= 0.01
            stood = 0 if moves else stood + 1
            return stood > 4

        self.until(stands, "the robot stands")

    def refusals(self) -> list[str]:
        """What the console refused this page, in its words."""
        return [f"{one.status} {one.request.method} {one.url}: {said(one)}" for one in self._refusals]

    def _note(self, message: ConsoleMessage) -> None:
        if message.type in ("error", "warning") and not any(part in message.text for part in HARMLESS):
            self.complaints.append(message.text)


def said(answer: Response) -> str:
    """The text of an answer, as far as the browser still has it."""
    try:
        return answer.text()[:300]
    except Error as gone:
        return str(gone)
