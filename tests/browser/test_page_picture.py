"""The README's picture: the page after a short tour of the simulated laboratory."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from running_console import Running
from visit import Visit

Open = Callable[..., Visit]


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
    here.fresh()
    assert len(console.ask("api/state")["landmarks"]) > 3
    assert here.page.evaluate("document.querySelector('.picture').width") > 0
    picture = Path(os.environ.get("BECKON_SCREENSHOT_DIR", tmp_path)) / "console.png"
    here.page.screenshot(path=picture)
    assert picture.stat().st_size > 30_000
    here.button("STOP").click()
    here.still()
