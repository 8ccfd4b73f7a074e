"""The page with its 3-D map: the README's picture after a short tour of the laboratory, and a map that is clicked."""

import os
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from playwright.sync_api import expect

from tests.browser.running_console import Running
from tests.browser.visit import PHONE, WITH_SCENE, Visit

Open = Callable[..., Visit]
MAP = np.s_[90:500, 200:640]  # rows, columns [px] of every picture where the map lies
PICTURES = "BECKON_SCREENSHOT_DIR"  # variable that names the folder for a picture worth keeping
SMALL_DESK = (1024, 640)  # [px]: less to draw where the processor does it
BLANK = 10.0  # standard deviation of the grey levels of a map on which there is nothing yet


@pytest.fixture(scope="module")
def chromium_flags() -> list[str]:
    return WITH_SCENE


@pytest.mark.campaign
def test_the_page_shows_a_robot_on_its_way_in_a_room_that_it_knows(
    visit: Open, console: Running, tmp_path: Path
) -> None:
    here = visit()
    here.told(lambda: here.say("turn left"), "done")
    here.told(lambda: here.say("stop at 0.5 and 0.8"), "done")
    here.show_scene(coarse=PICTURES not in os.environ)
    here.fresh()
    here.say("stop at 1.6 and -0.6")
    here.wait(3)
    pictures: list[bytes] = []

    def shows_the_map() -> bool:
        here.fresh()
        pictures.append(here.page.screenshot())
        return contrast(pictures[-1]) > BLANK

    here.until(shows_the_map, "the map is drawn", 60.0)
    assert len(console.ask("api/state")["landmarks"]) > 3
    assert here.page.evaluate("document.querySelector('.picture').width") > 0
    Path(os.environ.get(PICTURES, tmp_path), "console.png").write_bytes(pictures[-1])
    here.button("STOP").click()
    here.still()


def contrast(picture: bytes) -> float:
    """Standard deviation of the grey levels of the map in a PNG."""
    grey = cv2.imdecode(np.frombuffer(picture, np.uint8), cv2.IMREAD_GRAYSCALE)
    assert grey is not None
    return float(grey[MAP].std())


@pytest.mark.campaign
def test_a_click_on_the_floor_goes_there_and_keys_reach_the_page_through_the_scene(
    visit: Open, console: Running
) -> None:
    here = visit(size=SMALL_DESK)
    here.show_scene(coarse=True)
    before = console.newest()["id"]
    box = here.find("#scene").bounding_box()
    assert box is not None
    clicks = 0
    while console.newest()["id"] == before and clicks < 10:  # a scene that is still being built hears nothing
        here.page.mouse.click(box["x"] + box["width"] * 0.5, box["y"] + box["height"] * 0.6)
        clicks += 1
        here.wait(2.0)
    assert console.newest()["id"] > before, "no click was heard"
    assert console.newest()["source"] == "click"
    assert here.page.evaluate("document.activeElement.id") == "scene"
    here.page.keyboard.press("Space")
    here.until(lambda: console.newest()["state"] != "running", "Space in the scene stops", 3.0)
    here.page.keyboard.down("a")
    expect(here.find(".way[data-way=left][data-lit], .drive-why[data-tone]").first).to_be_visible()
    here.page.keyboard.up("a")
    expect(here.find(".way[data-lit]")).to_have_count(0)
    here.page.keyboard.press("/")
    assert here.page.evaluate("document.activeElement.id") == "words"
    here.still()
    here.until(lambda: contrast(here.page.screenshot()) > BLANK, "the map is drawn", 60.0)
    for size in (SMALL_DESK, PHONE):
        here.page.set_viewport_size({"width": size[0], "height": size[1]})
        here.wait(0.3)
        panels = here.page.frame_locator("#scene").locator(
            '[data-testid^="floating-panel"], [data-floating-window], .mantine-Paper-root[style*="position: fixed"]'
        )
        assert not any(panel.is_visible() for panel in panels.all())
