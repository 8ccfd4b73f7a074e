"""Another robot at the same address: a recording and a simulated one are opened on the Connect page."""

from __future__ import annotations

import re
import urllib.error
from collections.abc import Callable, Iterator

import pytest
from playwright.sync_api import expect

from tests.browser.running_console import Running
from tests.browser.visit import Visit
from tests.core.recording.log_writers import carmen_lines

Open = Callable[..., Visit]
LONG = 60_000  # [ms] of a busy machine's
AWAY = re.compile("ERR_CONNECTION|ERR_EMPTY_RESPONSE|WebSocket|503|422")
"""Browsers' complaints while the console starts again, and of the recording that is refused."""


@pytest.fixture(scope="module")
def console(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    folder = tmp_path_factory.mktemp("recordings")
    recordings = folder / "home" / "recordings"
    recordings.mkdir(parents=True)
    (recordings / "damaged.mcap").write_bytes(b"nothing")
    (recordings / "walk.log").write_text("\n".join(carmen_lines()))
    (folder / "exchange").mkdir()
    with Running(folder, "--text-files", str(folder / "exchange")) as running:
        yield running


def test_a_recording_is_opened_a_damaged_one_is_not_and_the_way_leads_back(visit: Open, console: Running) -> None:
    here = visit()
    page = here.page
    here.told(lambda: here.say("continue 0.5 meters"), "done")
    before = console.ask("api/state")["seq"]
    page.get_by_role("link", name="Connect").first.click()
    here.button("log:damaged.mcap").click()
    here.find(".connect-question").get_by_role("button", name="Open", exact=True).click()
    expect(here.find(".connect-status")).to_contain_text("not an MCAP file", timeout=LONG)
    assert console.ask("api/state")["seq"] > before, "the session goes on"
    here.button("log:walk.log").click()
    expect(here.find(".connect-question:visible")).to_contain_text("Your map is not saved")
    here.button("Save and open").click()
    page.wait_for_url(console.url, timeout=LONG)
    expect(here.button("Play the recording")).to_be_visible(timeout=LONG)

    page.get_by_role("link", name="Connect").first.click()
    page.get_by_label("URL of a robot").fill("sim:floor")
    here.button("Open").click()
    page.wait_for_url(console.url, timeout=LONG)
    expect(page.locator('[data-command="turn_left"]')).to_be_enabled(timeout=LONG)
    assert console.ask("api/robot/connection")["connection"]["url"] == "sim:floor"
    assert [one["name"][:4] for one in console.ask("api/maps")["maps"]] == ["map "]
    here.complaints[:] = [one for one in here.complaints if not AWAY.search(one)]


def test_with_another_robot_a_text_file_is_still_obeyed_and_once(visit: Open, console: Running) -> None:
    """The console's options hold for the robot that was opened, too."""
    here = visit()
    (console.trace.parent / "exchange" / "speech.txt").write_text("turn left\n")

    def turns() -> list[str]:
        rows = console.ask("api/commands/history")["commands"]
        return [row["source"] for row in rows if row["name"] == "turn_left"]

    here.until(lambda: bool(turns()), "it is obeyed", 20)
    here.wait(1.0)
    assert turns() == ["file"]
    console.ask("api/stop", {})
    console.until_nobody_drives()


@pytest.mark.parametrize(
    ("url", "says"),
    [
        ("log:absent.mcap", "There is no recording absent.mcap"),
        ("log:", "Only recordings and simulated robots"),
        ("foxglove://127.0.0.1:1", "Only recordings and simulated robots"),
        ("sim:moon", "Only recordings and simulated robots"),
    ],
)
def test_what_is_not_there_is_refused_and_the_robot_stays(console: Running, url: str, says: str) -> None:
    with pytest.raises(urllib.error.HTTPError) as refused:
        console.ask("api/robot/open", {"url": url})
    assert refused.value.code == 422 and says in refused.value.read().decode()
    assert console.ask("api/robot/connection")["connection"]["url"].startswith("sim:")
