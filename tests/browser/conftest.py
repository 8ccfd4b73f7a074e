"""A real console, a real Chromium, and pages that complain about nothing."""

import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.browser.running_console import Running
from tests.browser.visit import FLAT, Profiles, Visit
from tests.console.live_fleet import LiveFleet

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")

playwright_api = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed.")
Open = Callable[..., Visit]
Launch = Callable[[list[str]], playwright_api.Browser]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if item.nodeid.startswith("tests/browser/") and "launch" in getattr(item, "fixturenames", ()):
            item.add_marker(pytest.mark.browser)


def chromium_path(playwright: playwright_api.Playwright) -> str | None:
    """The browser to drive: what BECKON_CHROMIUM names, the system's, or Playwright's own."""
    named = os.environ.get("BECKON_CHROMIUM")
    found = next((path for name in NAMES if (path := shutil.which(name))), None)
    own = playwright.chromium.executable_path
    return named or found or (own if Path(own).exists() else None)


@pytest.fixture(scope="module")
def chromium_flags() -> list[str]:
    """How a file of tests wants its Chromium: `WITH_SCENE` where it looks at the 3-D map, which costs a processor."""
    return FLAT


@pytest.fixture(scope="package")
def playwright() -> Iterator[playwright_api.Playwright]:
    """Drives the browsers of this folder: its event loop must not outlive them."""
    with playwright_api.sync_playwright() as playwright:
        yield playwright


@pytest.fixture(scope="package")
def launch(request: pytest.FixtureRequest, playwright: playwright_api.Playwright) -> Launch:
    """Start a Chromium with flags."""
    path = chromium_path(playwright)
    if path is None:
        why = "There is no Chromium here: apt install chromium, or set BECKON_CHROMIUM."
        must = request.config.getoption("--require-browser") or os.environ.get("BECKON_REQUIRE_BROWSER")
        pytest.fail(why) if must else pytest.skip(why)
    caged = ["--no-sandbox"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []
    return lambda flags: playwright.chromium.launch(executable_path=path, args=[*flags, *caged])


@pytest.fixture(scope="package")
def flat_profiles(launch: Launch) -> Iterator[Profiles]:
    """Those of the one Chromium that most files share: its start costs as much as three pages."""
    browser = launch(FLAT)
    yield Profiles(browser)
    browser.close()


@pytest.fixture(scope="module")
def profiles(request: pytest.FixtureRequest, launch: Launch, chromium_flags: list[str]) -> Iterator[Profiles]:
    """What the tests of a file browse with, one after another."""
    if chromium_flags == FLAT:
        yield request.getfixturevalue("flat_profiles")
        return
    browser = launch(chromium_flags)
    yield Profiles(browser)
    browser.close()


@pytest.fixture(scope="module")
def browser(profiles: Profiles) -> playwright_api.Browser:
    """The Chromium of a file of tests."""
    return profiles.browser


@pytest.fixture(scope="package")
def console(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    """The console on the simulated robot, with login, as a person starts it."""
    with Running(tmp_path_factory.mktemp("console")) as running:
        yield running


@pytest.fixture(scope="package")
def fleet(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LiveFleet]:
    """A fleet of three robots in this process; a fourth has a certificate, and never joined."""
    if shutil.which("openssl") is None:
        pytest.skip("a certificate needs openssl: apt install openssl")
    with LiveFleet(tmp_path_factory.mktemp("fleet"), "r1", "r2", "r3", away=("r4",)) as running:
        yield running


@pytest.fixture
def visit(profiles: Profiles, console: object) -> Iterator[Open]:
    """Open the page as someone, somehow; afterwards no page may have complained."""
    if isinstance(console, Running):  # shared by many files; a file's own console has no earlier visitors
        console.until_nobody_drives()
    visits: list[Visit] = []

    def open_page(**how: object) -> Visit:
        visits.append(Visit(profiles, how.pop("console", console), **how))  # type: ignore[arg-type]
        return visits[-1]

    yield open_page
    complaints = [complaint for visit in visits for complaint in visit.complaints]
    refusals = [refusal for visit in visits for refusal in visit.refusals()] if complaints else []
    for visit in visits:
        visit.close()
    assert complaints == [], refusals
