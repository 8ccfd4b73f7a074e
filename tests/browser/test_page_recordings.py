"""Recordings are made, listed and played; another robot is opened at the same address on the Connect page."""

import re
import urllib.error
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import expect

from tests.browser.running_console import Running
from tests.browser.test_page_access import AXE, COLOURS, violations
from tests.browser.visit import PHONE, Visit
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


@pytest.mark.campaign
def test_a_recording_is_opened_a_damaged_one_is_not_and_the_way_leads_back(visit: Open, console: Running) -> None:
    here = visit()
    page = here.page
    here.told(lambda: here.say("continue 0.5 meters"), "done")
    before = console.ask("api/state")["seq"]
    page.get_by_role("link", name="Connect").first.click()
    here.button("log:damaged.mcap").click()
    here.find(".connect-question").get_by_role("button", name="Open without saving").click()
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
    here.find("notice-toasts .toast").filter(has_text="was saved as").get_by_role("button", name="Show").click(
        timeout=LONG
    )
    expect(here.find(".map-saved:visible")).to_contain_text("map 2")
    page.get_by_role("link", name="Drive").first.click()
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


def words_are_inside(here: Visit) -> None:
    """The difference of both ways ends within its bar, and leaves the timeline its width, in every window."""
    for width in (1100, 1440, 1920):
        here.page.set_viewport_size({"width": width, "height": 1000})
        parts = ("playback-bar", "playback-ways .difference", ".timeline")
        bar, words, line = (here.find(part).bounding_box() for part in parts)
        assert bar and words and words["x"] + words["width"] <= bar["x"] + bar["width"], width
        assert line and line["width"] >= 190, width


def take_film_and_part(here: Visit) -> None:
    """Two seconds of the form that is open."""
    here.page.get_by_label("From [s]").fill("0.5")
    here.page.get_by_label("To [s]").fill("2.5")
    with here.page.expect_download(timeout=LONG) as taken:
        here.page.get_by_role("link", name="Film (WEBP)").click()
    assert taken.value.suggested_filename.endswith(".webp")
    assert Path(taken.value.path()).read_bytes()[8:12] == b"WEBP"
    here.page.get_by_role("button", name="As a recording").click()


def export_a_part(here: Visit) -> None:
    """Two seconds as a film, and as a recording of its own, which is deleted again."""
    here.button("Export a part of a turn").click()
    take_film_and_part(here)
    part = here.find('[data-recording="a turn 0-2 s"]')
    expect(part).to_contain_text("0:0", timeout=LONG)
    assert AXE.exists() is False or violations(here.page, AXE.read_text()) == []
    part.get_by_role("button", name=re.compile("^Delete")).click()
    here.button("Delete").click()


def test_the_drive_has_its_report_there_and_a_list_that_could_not_be_read_is_read_again(
    visit: Open, console: Running
) -> None:
    here = visit()
    here.page.route("**/api/recordings", lambda route: route.fulfill(body="?"))
    here.page.goto(f"{console.url}recordings")
    expect(here.find("recordings-list [role=status]")).to_contain_text("did not work")
    here.page.unroute("**/api/recordings")
    expect(here.find("recordings-list [role=status]")).to_be_hidden(timeout=LONG)
    expect(here.find(".recording").first).to_be_visible()
    here.page.set_viewport_size({"width": 1920, "height": 1080})
    boxes = [box for row in here.find(".recording").all() if (box := row.bounding_box())]
    assert len(boxes) >= 2 and boxes[0]["y"] == boxes[1]["y"] and boxes[1]["x"] > boxes[0]["x"], "a gallery"
    report = here.page.get_by_role("link", name="Drive report")
    assert "commands" in here.page.request.get(report.get_attribute("href") or "").text().lower()


def test_a_drive_is_recorded_kept_named_deleted_and_played(visit: Open, console: Running) -> None:
    here, watching = visit(), visit(size=PHONE, theme="light", watching=True)
    record = here.find(".bar .recorder")
    record.click()
    expect(record.locator(".recorder-words")).to_have_text("End", timeout=LONG)
    expect(watching.find(".bar .recorder-time")).to_have_text(re.compile(r"^\d:\d\d$"))
    here.say("continue 0.5 meters")
    expect(watching.find(".bar .recorder")).to_have_attribute("aria-label", re.compile("only an operator"))
    watching.find("app-menu button").first.click()
    watching.page.get_by_role("button", name=re.compile("^Keep what just happened")).click()
    kept = watching.find(".toast").filter(has_text="Kept as")
    expect(kept).to_be_visible(timeout=LONG)
    kept.get_by_role("button", name="Show").click()
    expect(watching.find('.recording[data-state="runs"]')).to_contain_text("It is being recorded.")
    just_kept = watching.find('.recording[data-state="whole"]').filter(has_text=re.compile(r"viewer \d+ kept it\."))
    expect(just_kept.get_by_role("button")).to_have_count(1)  # a film may be taken away, too
    here.until(lambda: console.newest()["state"] != "running", "it has driven", LONG / 1000)
    record.click()
    toast = here.find(".toast").filter(has_text="Recorded:")
    toast.get_by_role("button", name="Show").click(timeout=LONG)
    rows = here.find(".recording")
    expect(rows.filter(has_text="kept it")).to_have_count(1)
    if AXE.exists():
        assert violations(here.page, AXE.read_text()) == violations(watching.page, AXE.read_text(), COLOURS) == []
    drive = here.find('.recording[data-recording^="20"]').filter(has_not_text="kept it")  # named by its time
    drive.get_by_role("button", name=re.compile("^Rename")).click()
    here.page.get_by_role("textbox", name="Name", exact=True).fill("a turn")
    here.page.get_by_label(re.compile("^Note")).fill("in the lab")
    here.page.keyboard.press("Enter")
    expect(here.find('[data-recording="a turn"]')).to_contain_text("in the lab")
    export_a_part(here)
    rows.filter(has_text="kept it").get_by_role("button", name=re.compile("^Delete")).click()
    here.button("Delete").click()
    expect(rows.filter(has_text="kept it")).to_have_count(0)
    here.button("Play a turn").click()
    here.find(".recording .map-question").get_by_role("button", name="Open without saving").click()
    here.page.wait_for_url(console.url, timeout=LONG)
    expect(here.find(".bar .recorder")).to_have_attribute("aria-disabled", "true", timeout=LONG)
    here.until(lambda: console.ask("api/state")["robot"]["progress"] > 0.1, "one press opened and plays it")
    expect(here.find("playback-ways").get_by_role("button", name="As computed now")).to_be_visible()
    here.page.get_by_label("Compare").click()
    expect(here.find("playback-ways .difference")).to_contain_text(
        re.compile("apart, at most|The same to the last bit"), timeout=LONG
    )
    words_are_inside(here)
    here.button("As computed now").click()
    expect(here.button("As computed now")).to_have_attribute("aria-pressed", "true")
    here.button("Export…").click()
    here.button("From here").click()
    expect(here.page.get_by_label("From [s]")).to_have_value(re.compile(r"^\d+\.\d$"))
    take_film_and_part(here)
    expect(here.find(".toast").filter(has_text="Kept as a turn 0-2 s")).to_be_visible(timeout=LONG)
    for visitor in (here, watching):
        visitor.complaints[:] = [one for one in visitor.complaints if not AWAY.search(one)]
