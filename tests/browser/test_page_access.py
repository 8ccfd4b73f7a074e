"""Every page in both themes by axe-core: no violation of any impact; what is pressed is 24 px; 400 % zoom reflows."""

import os
import re
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from tests.browser.running_console import REPOSITORY, Running
from tests.browser.visit import DESK, PHONE, Visit
from tests.console.live_fleet import LiveFleet

Open = Callable[..., Visit]
AXE = REPOSITORY / "node_modules" / "axe-core" / "axe.min.js"
PAGES = ("people", "hearing", "maps", "recordings", "experiments", "connect", "calibrate", "help")
LEAST = 24  # [px], WCAG 2.5.8
TIGHT = (320, 256)  # 1280x1024 at 400 %


@pytest.fixture(scope="module")
def axe() -> str:
    """The checker, as text."""
    if not AXE.exists():
        why = "axe-core is not installed: npm install."
        pytest.fail(why) if os.environ.get("BECKON_REQUIRE_BROWSER") else pytest.skip(why)
    return AXE.read_text()


COLOURS = ["color-contrast", "link-in-text-block"]  # the rules whose answer the theme can change


OTHER_TYPE = """() => [...document.querySelectorAll("body *")]
  .filter((one) => [...one.childNodes].some((child) => child.nodeType === Node.TEXT_NODE && child.data.trim()))
  .filter((one) => one.checkVisibility({ visibilityProperty: true }))
  .filter((one) => !["13px", "15px", "24px"].includes(getComputedStyle(one).fontSize)) // --small, --body, --figure
  .map((one) => `${getComputedStyle(one).fontSize}: ${one.outerHTML.slice(0, 120)}`)"""
FORGET_PAGES = "document.querySelectorAll('main[hidden]').forEach((left) => left.remove())"  # axe would walk them


def violations(page: Page, axe: str, rules: list[str] | None = None) -> list[str]:
    """What axe-core finds on the page as it stands, one line each; `rules`: only these, None: all."""
    if not page.evaluate("'axe' in window"):
        page.evaluate(axe)
    options: dict[str, Any] = {"resultTypes": ["violations"], "iframes": False}
    found: dict[str, Any] = page.evaluate(
        "options => axe.run(document, options)", options | ({"runOnly": rules} if rules else {})
    )
    return [
        f"{one['id']} ({one['impact']}): {node['html'][:160]} {node['failureSummary'][:300]}"
        for one in found["violations"]
        for node in one["nodes"]
    ]


def test_axe_has_nothing_to_say_about_any_page_in_either_theme_and_all_type_has_three_sizes(
    visit: Open, fleet: LiveFleet, axe: str
) -> None:
    here = visit(theme="dark")
    said: dict[str, list[str]] = {}

    def look(where: str) -> None:
        said[where] = [*violations(here.page, axe), *here.page.evaluate(OTHER_TYPE)]
        here.page.emulate_media(color_scheme="light")
        said[f"{where}, light"] = violations(here.page, axe, COLOURS)
        here.page.emulate_media(color_scheme="dark")

    look("console")
    here.say("turn lift")
    expect(here.find("command-status .suggested button").first).to_be_visible()
    for name in ("Estimate", "Voices", "SLAM", "Places", "Notices"):
        here.open_tab(name)
        look(name)
    for opener in ("link-chip", "lease-chip", "app-menu"):
        button = here.find(f"{opener} button").first
        button.click()
        look(opener)
        button.click()
    here.page.keyboard.press("?")
    look("keys")
    for path in PAGES:
        here.go(path)
        here.page.evaluate(FORGET_PAGES)
        here.wait(0.3)
        look(path)
    open_fleet(here, fleet)
    look("fleet")
    assert {where: what for where, what in said.items() if what} == {}


def test_in_german_too_what_is_pressed_is_named_by_its_words(
    visit: Open, console: Running, fleet: LiveFleet, axe: str
) -> None:
    console.ask("api/places", {"name": "kitchen", "x_m": 1.0, "y_m": 0.5, "heading_rad": None})
    german = "localStorage.setItem('beckon.language', 'de')"
    here = visit(before=lambda page: page.add_init_script(german))
    said = {}
    for path in ("", *PAGES, "fleet"):
        if path == "fleet":
            open_fleet(here, fleet)
        elif path:
            here.go(path)
        for size in (DESK, PHONE):
            here.page.set_viewport_size({"width": size[0], "height": size[1]})
            said[path, size] = violations(here.page, axe, ["label-content-name-mismatch"])
    console.ask("api/places/kitchen", method="DELETE")
    assert {where: what for where, what in said.items() if what} == {}


def test_stop_stays_red_in_forced_colours_and_nothing_moves_for_who_wants_no_motion(visit: Open) -> None:
    here = visit()
    stop = here.find(".stop")
    for wish in ({"forced_colors": "active"}, {"contrast": "more"}):
        here.page.emulate_media(**wish)
        expect(stop).to_have_css("background-color", re.compile(r"rgb\((1[5-9]|20)\d, \d+, \d+\)"))
        expect(stop).to_have_css("border-top-style", "solid")
    here.page.emulate_media(reduced_motion="reduce")
    here.say("turn left")
    expect(here.find('command-status[data-state="running"]')).to_be_visible()
    assert here.find("command-status > .icon").evaluate("icon => icon.getAnimations().length") == 0
    here.page.keyboard.press("Escape")
    here.still()


SMALL = """least => [...document.querySelectorAll("button, a[href], input, summary, [role=tab]")]
  .filter((one) => one.checkVisibility({ visibilityProperty: true }) && !one.closest(".skip"))
  .filter((one) => one.localName !== "a" || !one.closest("p, dd, li, td, h2, h3")) // links in text
  .map((one) => [one.outerHTML.slice(0, 120), (one.closest("label") ?? one).getBoundingClientRect()])
  .filter(([, { width, height }]) => width > 1 && height > 1 && Math.min(width, height) < least)
  .map(([what, { width, height }]) => `${what} ${Math.round(width)}x${Math.round(height)}`)"""


def open_fleet(here: Visit, fleet: LiveFleet) -> None:
    """The fleet's page with all that it can show: answers to a halt, robots on one map, one that never came."""
    fleet.share_a_map("r1", "r2")
    fleet.ask("POST", "/api/fleet/halt", token=fleet.operator, headers={"content-length": "0"})
    here.page.goto(fleet.driving)
    for part in ("fleet-answers", ".fleet-map", ".fleet-halted", '.fleet-card[data-group="away"]'):
        expect(here.find(part)).to_be_visible()
    here.find(".fleet-take summary").click()


def test_what_is_pressed_is_large_enough_and_the_page_reflows(visit: Open, fleet: LiveFleet) -> None:
    here = visit(size=PHONE)
    small = {}
    for path in ("", *PAGES, "fleet"):
        if path == "fleet":
            open_fleet(here, fleet)
        elif path:
            here.go(path)
        for size in (DESK, PHONE, TIGHT):
            here.page.set_viewport_size({"width": size[0], "height": size[1]})
            small[path, size] = here.page.evaluate(SMALL, LEAST)
            wide = here.page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
            assert wide <= 0, (path, size, wide)
    assert {where: what for where, what in small.items() if what} == {}


def test_in_the_colours_of_the_system_what_is_chosen_is_told_from_what_is_not(visit: Open) -> None:
    here = visit()
    here.page.emulate_media(forced_colors="active")
    groups = ("map-switch button", "drive-pad .preset", "tab-card [role=tab]", ".pages-link")
    for buttons in groups:
        chosen = here.find(f"{buttons}:is([aria-pressed=true], [aria-selected=true], [aria-current])").first
        other = here.find(f"{buttons}:not([aria-pressed=true], [aria-selected=true], [aria-current])").first
        expect(chosen).to_be_visible()
        grounds = [one.evaluate("one => getComputedStyle(one).backgroundColor") for one in (chosen, other)]
        assert grounds[0] != grounds[1], buttons
