"""The pictures and the film of README and documentation: `python -m tests.pictures [FOLDER]`.

Starts the console on the simulator, drives it in headless Chromium, and writes console.webp (dark, 3-D map),
console-light.webp (someone calls, flat map), camera.webp, phone.webp, calibration.webp, a picture of each page of
`GALLERY` and film.webp (below 3 MB, twice as fast as life). Needs the extra `test`, a Chromium, a speech recognizer,
and OpenCV 4.11 or newer for the film.
"""

import argparse
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
from playwright.sync_api import Browser, Page, expect, sync_playwright

from core.message import Array
from tests.browser.conftest import chromium_path
from tests.browser.running_console import Running
from tests.browser.visit import FLAT, WITH_SCENE

PLACE = Path(__file__).parent.parent / "static" / "img"
DESK, PHONE, FILM = (1280, 800), (390, 844), (1180, 740)
FILM_WIDTH = 900  # [pixel]
PERIOD = 0.4  # [s] between two pictures of the film
FASTER = 2  # than life
MOST = 3_000_000  # [byte] of the film
QUALITIES = (70, 55, 40, 25)  # of the film, the best that fits
STILL_QUALITY = 88
GALLERY = ("maps", "people", "experiments", "connect")  # pages
LONG = 90_000  # [ms]
FRESH_S = 5.0  # [s] that a picture waits for a machine that is not busy


def page_of(browser: Browser, console: Running, size: tuple[int, int], theme: str, kind: str) -> Page:
    """The console's page, signed in, without the first hints; `kind` of map: flat or 3-D."""
    context = browser.new_context(
        viewport={"width": size[0], "height": size[1]},
        color_scheme="light" if theme == "light" else "dark",
        has_touch=size == PHONE,
        device_scale_factor=2 if size == PHONE else 1,
        reduced_motion="reduce" if kind == "3-D" else "no-preference",  # that map leaves a fade no time
    )
    for name, value in (("hints", "seen"), ("map", kind)):
        context.add_init_script(f"localStorage.setItem('beckon.{name}', '{value}')")
    page = context.new_page()
    page.goto(console.driving)
    expect(page.locator("link-chip")).to_contain_text("Hz", timeout=LONG)
    return page


def say(page: Page, words: str) -> None:
    """Type words and send them."""
    page.locator("#words").fill(words)
    page.keyboard.press("Enter")
    page.locator("#words").blur()


def shot(page: Page) -> Array:
    """What is seen (H, W, 3), blue first."""
    seen = cv2.imdecode(np.frombuffer(page.screenshot(type="png", timeout=LONG), np.uint8), cv2.IMREAD_COLOR)
    assert seen is not None
    return seen


def keep(page: Page, path: Path) -> None:
    """Write what is seen, where it can be while the camera's picture is new."""
    old = page.locator("camera-view.is-old:visible")
    until(page, lambda: old.count() == 0, FRESH_S)
    cv2.imwrite(str(path), shot(page), [cv2.IMWRITE_WEBP_QUALITY, STILL_QUALITY])


def until(page: Page, is_so: Callable[[], bool], seconds: float) -> None:
    """Let the page live until it is so, or the time is over."""
    end = time.monotonic() + seconds
    while not is_so() and time.monotonic() < end:
        page.wait_for_timeout(100)


def call(page: Page, words: str) -> None:
    """Ann says it in the simulated room."""
    page.get_by_role("tab", name="Voices", exact=True).click()
    page.locator('.person-chip[data-person="Ann"]').click()
    page.locator(f'[data-says="{words}"]').click()


def stills(browser: Browser, console: Running, folder: Path) -> None:
    """console-light.webp while Ann is approached, phone.webp."""
    page = page_of(browser, console, DESK, "light", "flat")
    page.wait_for_timeout(3000)
    call(page, "come here")
    expect(page.locator('.chain-step[data-step="coming"][data-lit]')).to_be_visible(timeout=LONG)
    page.wait_for_timeout(1500)
    keep(page, folder / "console-light.webp")
    until(page, lambda: console.newest()["state"] != "running", 60)
    page.context.close()
    console.until_nobody_drives()

    page = page_of(browser, console, PHONE, "dark", "flat")
    page.wait_for_timeout(2000)
    say(page, "turn right")
    page.wait_for_timeout(1500)
    keep(page, folder / "phone.webp")
    page.context.close()


def wizard(browser: Browser, console: Running, folder: Path) -> None:
    """calibration.webp: the fourth view of the board that a simulated person holds."""
    page = page_of(browser, console, DESK, "dark", "flat")
    page.goto(console.url + "calibrate")
    page.get_by_role("button", name="Begin", exact=True).first.click()
    page.get_by_role("button", name="Start", exact=True).click()
    page.get_by_role("button", name="Show me", exact=True).click()
    expect(page.locator("views-card h2:visible")).to_contain_text("4 views", timeout=LONG)
    keep(page, folder / "calibration.webp")
    page.context.close()


def gallery(browser: Browser, console: Running, folder: Path) -> None:
    """camera.webp: the camera as the ground; then a picture of each page, with a saved map and a place on it."""
    page = page_of(browser, console, DESK, "dark", "flat")
    page.wait_for_timeout(2000)
    say(page, "turn left")
    until(page, lambda: console.newest()["state"] != "running", 30)
    page.locator("camera-view swap-button button").click()
    page.wait_for_timeout(1500)
    keep(page, folder / "camera.webp")
    console.ask("api/maps", {"name": "lab"})
    console.ask("api/places", {"name": "kitchen", "x_m": 1.2, "y_m": 0.8, "heading_rad": None})
    for name in GALLERY:
        page.goto(console.url + name)
        page.wait_for_timeout(3000)
        keep(page, folder / f"{name}.webp")
    page.context.close()


def portrait(browser: Browser, console: Running, folder: Path) -> None:
    """console.webp: under way on the 3-D map."""
    page = page_of(browser, console, DESK, "dark", "3-D")
    page.evaluate("document.querySelector('#scene').src += '&fixedDpr=0.5'")  # or its lines lag behind the robot
    expect(page.frame_locator("#scene").locator("canvas").first).to_be_visible(timeout=LONG)
    page.wait_for_timeout(12000)
    say(page, "stop at 1.4 and 0.9")
    until(page, lambda: console.truth()[0] > 0.7, 60)
    keep(page, folder / "console.webp")
    page.context.close()


def film(browser: Browser, console: Running) -> list[Array]:
    """Pictures (H, W, 3) of a turn, a way to a pressed point, a person who calls, and STOP."""
    page = page_of(browser, console, FILM, "dark", "flat")
    page.wait_for_timeout(2500)
    pictures: list[Array] = []

    def watch(seconds: float, over: Callable[[], bool] = lambda: False) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end and not over():
            next_one = time.monotonic() + PERIOD
            seen = shot(page)
            height = round(FILM_WIDTH * seen.shape[0] / seen.shape[1])
            pictures.append(cv2.resize(seen, (FILM_WIDTH, height), interpolation=cv2.INTER_AREA))
            page.wait_for_timeout(max(0.0, 1e3 * (next_one - time.monotonic())))

    def rests() -> bool:
        return console.newest()["state"] != "running"

    watch(1)
    say(page, "turn left")
    watch(1.5)
    watch(8, rests)
    say(page, "stop at 0.6 and 1.3")
    watch(1.5)
    watch(15, rests)
    call(page, "come here")
    watch(20, lambda: console.newest().get("name") == "come_here")  # it is read, and waits for an objection
    watch(1)
    watch(25, rests)
    watch(1)
    say(page, "continue 2 meters")
    watch(2)
    page.get_by_role("button", name="STOP").first.click()
    watch(2.5)
    page.context.close()
    return pictures


def write_film(pictures: list[Array], path: Path) -> None:
    """Write an animated WebP, as good as fits into `MOST`. Raises SystemExit where OpenCV cannot."""
    if not hasattr(cv2, "imwriteanimation"):
        raise SystemExit(
            "This OpenCV writes no animated WebP: pip install -U opencv-python-headless (4.11 or newer)."
        )
    for quality in QUALITIES:
        animation = cv2.Animation()
        animation.frames = pictures
        animation.durations = np.full(len(pictures), round(1e3 * PERIOD / FASTER), np.int32)
        cv2.imwriteanimation(str(path), animation, [cv2.IMWRITE_WEBP_QUALITY, quality])
        if path.stat().st_size <= MOST:
            return
    raise SystemExit(f"{path} has {path.stat().st_size / 1e6:.1f} MB, more than {MOST / 1e6:.0f}.")


def main(arguments: list[str]) -> None:
    """Write all of them."""
    parser = argparse.ArgumentParser(prog="python -m tests.pictures", description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("folder", type=Path, nargs="?", default=PLACE, help="where to write them")
    folder = parser.parse_args(arguments).folder
    folder.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as playwright:
        program = chromium_path(playwright)
        for flags, makes in (
            (FLAT, lambda browser, console: write_film(film(browser, console), folder / "film.webp")),
            (FLAT, lambda browser, console: stills(browser, console, folder)),
            (FLAT, lambda browser, console: wizard(browser, console, folder)),
            (FLAT, lambda browser, console: gallery(browser, console, folder)),
            (WITH_SCENE, lambda browser, console: portrait(browser, console, folder)),
        ):
            browser = playwright.chromium.launch(executable_path=program, args=[*flags, "--no-sandbox"])
            with tempfile.TemporaryDirectory() as home, Running(Path(home), people=True) as console:
                makes(browser, console)
            browser.close()
    for path in sorted(folder.glob("*.*")):
        sys.stdout.write(f"{path.name:20s} {path.stat().st_size / 1e3:8.0f} kB\n")


if __name__ == "__main__":
    main(sys.argv[1:])
