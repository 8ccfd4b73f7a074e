"""The camera's wizard from the empty form to the calibration in use, with a film instead of this browser's camera."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from core.optics import TABLE_3
from tests.browser.film import CAMERA, film
from tests.browser.running_console import Running
from tests.browser.visit import FLAT, Visit
from tests.console.calibration.wizard import with_a_thumb

Open = Callable[..., Visit]
SOON, LONG = 30_000, 120_000  # [ms]


@pytest.fixture(scope="module")
def chromium_flags(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    shown = film(tmp_path_factory.mktemp("film") / "board.y4m")
    return [
        *FLAT,
        "--use-fake-device-for-media-stream",
        "--use-fake-ui-for-media-stream",
        f"--use-file-for-fake-video-capture={shown}",
    ]


def session(here: Visit) -> dict[str, Any]:
    """The session that the page shows, as the server has it."""
    found = re.search(r"#s=(\w+)", here.page.url)
    assert found is not None, here.page.url
    return here.console.ask(f"api/calibration/sessions/{found[1]}")


def uncovered(here: Visit) -> int:
    """How many of the session's views its solution does not use."""
    now = session(here)
    return len(now["views"]) - int(now["solution"]["views_used"])


def begin(page: Page, columns: int, rows: int, source: str = "This device’s camera") -> None:
    expect(page.get_by_role("heading", name="Calibrate the camera")).to_be_visible(timeout=SOON)
    page.get_by_label(source).check(force=True)
    page.get_by_label("Inner corners across", exact=True).fill(str(columns))
    page.get_by_label("Inner corners down", exact=True).fill(str(rows))
    page.get_by_label("Side of a square").fill("30")
    page.get_by_role("button", name="Start", exact=True).click()


@pytest.mark.campaign
def test_a_camera_is_calibrated_by_whoever_follows_the_page(visit: Open, console: Running) -> None:
    here = visit(size=(1100, 760), at="calibrate")
    page = here.page
    expect(page.get_by_role("heading", name="Calibrate", exact=True)).to_be_visible(timeout=SOON)
    page.get_by_role("button", name="Begin", exact=True).first.click()

    begin(page, 10, 7)  # as those do who count squares
    expect(here.find("verdict-line")).to_contain_text("squares instead of inner corners", timeout=LONG)
    page.get_by_role("button", name="Use 9x6").click()

    verdict = here.find("verdict-line")
    expect(verdict).to_contain_text("Blurred", timeout=LONG)
    here.until(lambda: len(session(here)["views"]) >= 2, "two views were counted", 120.0)
    before = session(here)
    page.reload()
    expect(here.find("views-card h2:visible")).to_have_text(re.compile(r"^\d+ views"), timeout=SOON)
    after = session(here)
    assert after["id"] == before["id"]
    assert [view["name"] for view in after["views"]][:2] != []
    assert len(after["views"]) >= len(before["views"])
    expect(page.get_by_role("button", name="Mirror")).to_have_attribute("aria-pressed", "true")

    expect(here.find("progress-card[data-ready]")).to_be_visible(timeout=LONG)
    expect(here.find("progress-card")).to_contain_text("Done: 95 % of the picture")
    page.get_by_role("button", name="Done: review and use").click()
    review(here)
    page.get_by_role("button", name="Use this calibration").click()
    # The film has 320x240 pictures, the simulated camera 320x256.
    expect(page.get_by_role("heading", name="Accepted, but not used")).to_be_visible(timeout=SOON)
    expect(here.find(".review-words")).to_contain_text("pictures, this robot's camera gives")
    used = console.ask("api/calibration/in-use")["camera"]
    assert abs(used["fx"] - CAMERA.fx) < max(4 * used["sd"]["fx"], 1.0)
    assert used["image_size"] == [CAMERA.width, CAMERA.height]


def review(here: Visit) -> None:
    """What speaks for and against it is on the page, a view can be left out and taken back, files can be had."""
    page = here.page
    expect(page.get_by_role("heading", name="Good enough to be used")).to_be_visible(timeout=SOON)
    rows = here.find("values-card tbody tr")
    expect(rows.first).to_contain_text("±")
    assert rows.count() >= 8
    for picture in ("before-after img.after", ".review views-card img"):
        loaded = f"document.querySelector('{picture}').naturalWidth > 0"
        here.until(lambda loaded=loaded: page.evaluate(loaded), f"{picture} is loaded", 30.0)
    cards = "[...document.querySelectorAll('.review-column > *')]"
    within = cards + ".every(one => one.scrollWidth <= one.clientWidth)"
    for width, height in ((1366, 650), (390, 844), (1100, 760)):  # no picture is wider than its place
        page.set_viewport_size({"width": width, "height": height})
        here.until(lambda: page.evaluate(within), f"nothing reaches out of its card, {width} px wide", 10.0)
        assert page.evaluate("document.querySelector('main:not([hidden])').scrollWidth <= innerWidth"), width
    slider = page.get_by_label("Straightened from here on")
    slider.focus()
    page.keyboard.press("ArrowLeft")
    expect(slider).to_have_attribute("aria-valuetext", "51 % straightened")

    worst = session(here)["views"][0]["name"]
    page.get_by_role("button", name=f"Leave out: {worst}", exact=True).click()
    expect(page.get_by_role("button", name=f"Take back: {worst}", exact=True)).to_be_visible(timeout=SOON)
    here.until(lambda: uncovered(here) == 1, "solved anew", 30.0)
    page.get_by_role("button", name=f"Take back: {worst}", exact=True).click()
    here.until(lambda: uncovered(here) == 0, "solved with all of them", 30.0)
    for link in here.find("a.export").all():
        answer = page.request.get(str(link.get_attribute("href")))
        assert answer.status == 200, link.inner_text()
        assert len(answer.body()) > 100


def test_whoever_brings_pictures_is_not_asked_to_print_a_board_or_to_measure_another(visit: Open) -> None:
    here = visit(size=(1100, 760), at="calibrate")
    page = here.page
    page.get_by_role("button", name="Begin", exact=True).first.click()
    expect(page.get_by_role("heading", name="Calibrate the camera")).to_be_visible(timeout=SOON)
    page.get_by_label("The robot’s camera").check(force=True)
    page.get_by_label("Inner corners across", exact=True).fill("10")
    page.get_by_label("Inner corners down", exact=True).fill("7")
    page.get_by_label("Side of a square").fill("25")
    expect(page.get_by_text("Squares of 25 mm do not fit")).to_be_visible()  # on A4
    page.get_by_label("Picture files").check(force=True)
    expect(page.get_by_text("Squares of 25 mm do not fit")).to_be_hidden()
    expect(page.get_by_role("link", name="Print this board")).to_be_hidden()
    expect(here.find(".setup-plan")).to_contain_text("choose ten to twenty pictures of it")


@pytest.mark.campaign
def test_four_corners_are_dragged_onto_a_board_that_is_not_found(visit: Open, tmp_path: Path) -> None:
    covered, corners = with_a_thumb()
    (tmp_path / "a.png").write_bytes(covered)
    here = visit(size=(1100, 760), at="calibrate")
    page = here.page
    page.get_by_role("button", name="Begin", exact=True).first.click()
    begin(page, 9, 6, "Picture files")
    page.get_by_label("Pictures of the board").set_input_files(tmp_path / "a.png")
    expect(here.find(".attempt")).to_have_attribute("data-kind", "nothing", timeout=LONG)
    page.get_by_role("button", name="Mark the corners").click()
    shown = here.find(".marker-picture").bounding_box()
    assert shown is not None
    scale = shown["width"] / TABLE_3.width
    for number, (u, v) in enumerate(corners[[0, 8, 53, 45]].tolist(), start=1):
        page.get_by_role("button", name=f"Extreme corner {number};").hover()
        page.mouse.down()
        page.mouse.move(shown["x"] + (u + 0.5) * scale, shown["y"] + (v + 0.5) * scale)
        page.mouse.up()
    page.get_by_role("button", name="Extreme corner 4;").press("ArrowRight")
    page.get_by_role("button", name="Use these corners").click()
    here.until(lambda: len(session(here)["views"]) == 1, "the marked picture counts", 30.0)


@pytest.mark.real_data
def test_files_of_another_board_are_judged_again_with_the_board_that_is_seen(visit: Open, shared_data: Path) -> None:
    here = visit(size=(1100, 760), at="calibrate")
    page = here.page
    page.get_by_role("button", name="Begin", exact=True).first.click()
    begin(page, 7, 7, "Picture files")
    folder = shared_data / "chessboard-opencv-left"
    expect(page.get_by_role("button", name="Choose pictures").first).to_be_visible(timeout=SOON)
    page.get_by_label("Pictures of the board").set_input_files([folder / "left01.jpg", folder / "left02.jpg"])
    expect(here.find(".attempt")).to_have_count(1, timeout=LONG)  # one sentence for both
    expect(here.find(".attempt-name")).to_contain_text("left02.jpg, left01.jpg", timeout=LONG)
    expect(here.find("advice-line")).to_contain_text("This looks like a 9x6 board, not 7x7.")
    page.get_by_role("button", name="Use 9x6").click()
    expect(here.find("uploads-card h2")).to_have_text("2 of 2 files counted", timeout=LONG)
    expect(here.find(".attempt")).to_have_text("left02.jpg, left01.jpg")  # not “Counted as left02.jpg.” as well
