"""The README's picture: the page after a short tour of the simulated laboratory."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from playwright.sync_api import expect
from running_console import Running
from visit import Visit

Open = Callable[..., Visit]


def test_the_page_shows_a_robot_on_its_way_in_a_room_that_it_knows(
    visit: Open, console: Running, tmp_path: Path
) -> None:
    here = visit(scene=True)
    expect(here.page.frame_locator("#scene").locator("canvas").first).to_be_visible(timeout=20000)
    here.say("turn left")
    here.until(lambda: console.newest()["state"] == "done", "the turn is done", 15.0)
    here.say("stop at 1 and 0.5")
    here.until(lambda: console.newest()["state"] != "running" or console.speed() > 0.05, "it is on its way", 15.0)
    here.wait(2.5)
    assert len(console.ask("api/state")["landmarks"]) > 3
    assert here.page.evaluate("document.querySelector('.picture').width") > 0
    picture = Path(os.environ.get("BECKON_SCREENSHOT_DIR", tmp_path)) / "console.png"
    here.page.screenshot(path=picture)
    assert picture.stat().st_size > 30_000
    here.button("STOP").click()
    here.still()
