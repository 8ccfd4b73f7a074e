"""The README's picture: the page after a short tour of the simulated laboratory."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

from tests.browser.running_console import Running
from tests.browser.visit import Visit

Open = Callable[..., Visit]
MAP = np.s_[90:640, 200:1000]  # rows, columns [px] of the picture where the map lies
BLANK = 10.0  # standard deviation of the grey levels of a map on which there is nothing yet


def test_the_page_shows_a_robot_on_its_way_in_a_room_that_it_knows(
    visit: Open, console: Running, tmp_path: Path
) -> None:
    here = visit()
    here.told(lambda: here.say("turn left"), "done")
    here.told(lambda: here.say("stop at 0.5 and 0.8"), "done")
    here.show_scene()
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
    Path(os.environ.get("BECKON_SCREENSHOT_DIR", tmp_path), "console.png").write_bytes(pictures[-1])
    here.button("STOP").click()
    here.still()


def contrast(picture: bytes) -> float:
    """Standard deviation of the grey levels of the map in a PNG."""
    grey = cv2.imdecode(np.frombuffer(picture, np.uint8), cv2.IMREAD_GRAYSCALE)
    assert grey is not None
    return float(grey[MAP].std())
