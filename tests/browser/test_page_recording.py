"""A recording on the page: it waits, is played and sought by keys, and its marks lead to their places."""

import json
from collections.abc import Callable, Iterator

import pytest
from playwright.sync_api import expect

from tests.browser.visit import Visit
from tests.console.live import Live

Open = Callable[..., Visit]
STAMPS = [0.1 * n for n in range(400) if not 100 < n < 140]  # [s]


class Cinema:
    def __init__(self, live: Live) -> None:
        self.live = live
        self.driving = f"http://127.0.0.1:{live.port}/#t={live.operator}"


@pytest.fixture(scope="module")
def console(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cinema]:
    folder = tmp_path_factory.mktemp("recording")
    log = folder / "room.jsonl"
    ranges = [2.0 + 0.01 * beam for beam in range(90)]
    log.write_text("".join(json.dumps({"t": stamp, "ranges": ranges}) + "\n" for stamp in STAMPS))
    with Live(folder, url=f"log:{log}") as live:
        yield Cinema(live)


def test_a_recording_waits_and_is_steered_by_keys_and_marks(visit: Open, console: Cinema) -> None:
    here = visit()
    time, stop = here.find(".playback-time"), here.find(".stop")
    expect(time).to_have_text("0:00 of 0:39")
    expect(stop).to_have_text("PauseEsc")
    red, green, _ = (
        int(part)
        for part in stop.evaluate("it => getComputedStyle(it).backgroundColor")
        .split("(")[1]
        .rstrip(")")
        .split(",")[:3]
    )
    assert abs(red - green) < 40, "neutral, not red"
    here.button("Export…").click(force=True)  # it says why not
    expect(here.find(".toast")).to_contain_text("only of a recording that Beckon made")
    mark = here.find(".mark[data-kind=gap]")
    expect(mark).to_have_attribute("title", "0:10: No scans for 4.0 s")
    here.page.keyboard.press("Space")
    here.until(lambda: console.live.runtime.snapshot.running, "Space plays")
    here.page.keyboard.press("Space")
    here.until(lambda: not console.live.runtime.snapshot.running, "Space pauses")
    mark.click()
    expect(time).to_have_text("0:10 of 0:39")
    here.page.keyboard.press("ArrowRight")
    here.page.keyboard.press("ArrowRight")
    expect(time).to_have_text("0:20 of 0:39")
    here.page.keyboard.press("ArrowLeft")
    expect(time).to_have_text("0:15 of 0:39")
