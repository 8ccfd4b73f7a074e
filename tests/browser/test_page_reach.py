"""STOP in reach at every size and over everything, the page by keys alone, themes, signing in, a recording."""

from __future__ import annotations

import time
from collections.abc import Callable

import pytest
from playwright.sync_api import Browser, expect

from tests.browser.running_console import Running, write_log
from tests.browser.visit import DESK, PHONE, Visit

Open = Callable[..., Visit]
SMALLEST = 64  # [px] of STOP


def stop_is_free(here: Visit) -> bool:
    """Whether a finger on any part of STOP meets STOP."""
    return here.page.evaluate(
        """least => {
            const { left, top, width, height } = document.querySelector(".stop").getBoundingClientRect();
            if (Math.min(width, height) < least || left < 0 || top < 0) return false;
            if (left + width > innerWidth || top + height > innerHeight) return false;
            return [0.1, 0.5, 0.9].every((x) => [0.1, 0.5, 0.9].every((y) =>
                document.elementFromPoint(left + x * width, top + y * height)?.closest(".stop")));
        }""",
        SMALLEST,
    )


@pytest.mark.parametrize("size", [DESK, PHONE, (360, 640), (844, 390)])
def test_stop_is_large_and_free_whatever_is_open(visit: Open, size: tuple[int, int]) -> None:
    here = visit(size=size, hints=True)
    expect(here.find(".coach")).to_be_visible()
    for _ in range(5):
        assert stop_is_free(here)
        here.find(".coach-foot button").click()
    for opener in ("link-chip button", "lease-chip button", "app-menu button"):
        here.find(opener).first.click()
        assert stop_is_free(here), opener
        here.find(opener).first.click()
    for tab in here.find(".view-tab").all():
        if tab.is_visible():
            tab.click()
            assert stop_is_free(here)
    here.page.keyboard.press("?")
    assert here.find("key-sheet").is_visible()
    assert stop_is_free(here)
    assert here.page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_the_page_can_be_used_by_keys_alone(visit: Open, console: Running) -> None:
    here = visit()
    met: list[str] = []
    for _ in range(60):
        here.page.keyboard.press("Tab")
        name, ringed = here.page.evaluate(
            """() => {
                const at = document.activeElement;
                const style = getComputedStyle(at);
                const told = at.getAttribute("aria-label") || at.labels?.[0]?.textContent;
                const name = told || at.textContent || at.title;
                const ringed = style.outlineStyle !== "none" || at.closest(".is-focused") !== null;
                return [at === document.body ? "" : at.localName + " " + name.trim(), ringed];
            }"""
        )
        if not name:
            break
        assert ringed, name
        assert name.split(" ", 1)[1], name
        met.append(name)
    told = "\n".join(met)
    for wanted in (
        "Skip to",
        "Link",
        "Who drives",
        "Theme",
        "Menu",
        "STOP",
        "3-D map",
        "Tell the robot",
        "turn left",
    ):
        assert wanted in told, wanted

    def press(what: str) -> None:
        here.find(what).focus()
        here.page.keyboard.press("Enter")

    here.told(lambda: press("[data-command='turn_right']"), "cancelled", then=lambda: press(".stop"))


def test_single_keys_can_be_switched_off_but_escape_cannot(visit: Open, console: Running) -> None:
    here = visit()
    here.find("app-menu button").first.click()
    here.page.get_by_role("switch").click()
    here.page.keyboard.press("Escape")
    here.page.keyboard.down("w")
    here.wait(0.4)
    here.page.keyboard.up("w")
    assert abs(console.speed()) < 0.005
    here.told(lambda: here.say("turn left"), "cancelled", then=lambda: here.page.keyboard.press("Escape"))


def test_the_theme_is_chosen_and_remembered(visit: Open) -> None:
    here = visit(theme="light")
    ground = "getComputedStyle(document.documentElement).backgroundColor"
    light = here.page.evaluate(ground)
    here.find("theme-toggle button").click()
    dark = here.page.evaluate(ground)
    assert dark != light
    here.page.reload()
    expect(here.find("link-chip")).to_contain_text("Hz", timeout=10000)
    assert here.page.evaluate(ground) == dark


def test_without_a_login_the_page_asks_for_the_token_and_takes_the_whole_link(
    browser: Browser, console: Running
) -> None:
    context = browser.new_context()
    page = context.new_page()
    page.route("**/scene/**", lambda route: route.abort())
    page.goto(console.url)
    page.get_by_label("Token").fill("wrong")
    page.keyboard.press("Enter")
    expect(page.get_by_role("alert").filter(has_text="token")).to_be_visible()
    page.get_by_label("Token").fill(console.driving)
    page.keyboard.press("Enter")
    expect(page.locator("link-chip")).to_contain_text("Hz", timeout=10000)
    page.evaluate("link => { location.href = link }", console.driving)
    until = time.monotonic() + 5
    while page.evaluate("location.hash") and time.monotonic() < until:
        page.wait_for_timeout(50)
    assert page.evaluate("location.href") == console.url
    context.close()


def test_a_recording_is_played_and_cannot_be_driven(
    browser: Browser, visit: Open, tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.mktemp("recording")
    with Running(folder, "--robot", f"log:{write_log(folder / 'corridor.log')}") as playing:
        here = visit(console=playing)
        expect(here.find(".badge")).to_have_text("LOG")
        for absent in ("drive-pad", "command-line", "command-chips", "lease-chip"):
            assert not here.find(absent).is_visible(), absent
        here.button("Pause").click()
        expect(here.button("Play")).to_be_visible()
        before = here.find(".seek").input_value()
        here.find(".seek").press("ArrowRight")
        assert here.find(".seek").input_value() > before
        here.find(".seek").fill("500")
        here.until(lambda: abs(playing.ask("api/state")["robot"]["progress"] - 0.5) < 0.1, "half way")
        here.button("2×").click()
        here.until(lambda: playing.ask("api/state")["robot"]["speed"] == 2, "twice as fast")
        here.button("Play").click()
        expect(here.button("Pause")).to_be_visible()
        assert stop_is_free(here)
