"""The laser's wizard on the simulated robot: the demo shows how, the page follows, the truth is near."""

import json
import re
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Locator, expect

from core.optics import TABLE_3
from tests.browser.running_console import Running
from tests.browser.visit import PHONE, Visit

Open = Callable[..., Visit]
SOON, LONG = 30_000, 240_000  # [ms]


def camera_file() -> dict[str, Any]:
    """The simulated robot's true camera, as someone might bring it from another program."""
    names = ("k1", "k2", "p1", "p2", "k3")
    model = TABLE_3
    return {
        "name": "camera.json",
        "mimeType": "application/json",
        "buffer": json.dumps(
            {
                "format": "beckon-calibration",
                "version": 1,
                "camera": {
                    "name": "camera",
                    "image_size": [model.width, model.height],
                    "K": [[model.fx, 0, model.cx], [0, model.fy, model.cy], [0, 0, 1]],
                    "dist_model": "plumb_bob",
                    "dist": [getattr(model, name) for name in names],
                },
            }
        ).encode(),
    }


@pytest.mark.campaign
def test_the_laser_is_calibrated_by_the_demo_while_the_page_tells_how(visit: Open, console: Running) -> None:
    here = visit(size=(1100, 760), at="calibrate")
    page = here.page
    expect(page.get_by_role("heading", name="Calibrate", exact=True)).to_be_visible(timeout=SOON)
    here.find("#camera-file").set_input_files(camera_file())
    expect(here.find("[data-kind=camera] .wizard-used")).to_contain_text("In use", timeout=SOON)
    here.find("[data-kind=laser]").get_by_role("button", name="Begin", exact=True).click()
    expect(page.get_by_role("heading", name="Calibrate the laser on the camera")).to_be_visible()
    page.get_by_role("button", name="Start", exact=True).click()

    expect(here.find("verdict-line")).to_contain_text("empty room", timeout=SOON)
    page.get_by_role("button", name="Show me").click()
    found = re.search(r"#s=(\w+)", page.url)
    assert found is not None
    path = f"api/calibration/sessions/{found[1]}"
    seen = {"board in the scan": False, "points on the board": False}

    def solved() -> bool:
        told = console.ask(path)
        seen["board in the scan"] |= bool(told["scan"] and told["scan"]["board"])
        points = (told["verdict"] or {}).get("laser") or []
        seen["points on the board"] |= any(on_board for *_, on_board in points)
        return all(seen.values()) and bool(told["progress"]["precision"])

    here.until(solved, f"the first poses were taken and solved {seen}", 240.0)
    page.reload()
    expect(here.find("views-card h2:visible")).to_have_text(re.compile(r"^([4-9]|\d\d) poses"), timeout=SOON)
    expect(here.find("gains-card:visible")).to_contain_text("A laser point lands within")
    expect(here.find("progress-card[data-ready]")).to_be_visible(timeout=LONG)
    page.get_by_role("button", name="Done: review and use").click()
    expect(here.find("values-card tbody tr")).to_have_count(6)
    expect(here.find("values-card")).not_to_contain_text("not known")
    expect(here.find(".laser-offset-table")).to_contain_text("1.0 m")
    page.get_by_role("button", name="Use this calibration").click()
    expect(page.get_by_role("heading", name="In use", exact=True)).to_be_visible(timeout=SOON)
    assert console.ask("api/calibration/in-use")["laser"]["poses_used"] >= 6


def test_the_wizards_next_step_is_in_sight_on_every_window_and_never_under_stop(visit: Open) -> None:
    for size in (PHONE, (1366, 650)):
        here = visit(size=size, at="calibrate")
        here.find("[data-kind=camera]").get_by_role("button", name="Begin", exact=True).dispatch_event("click")
        start = here.button("Start")
        expect(start).to_be_visible(timeout=SOON)
        here.until(lambda start=start: is_on_top(start), f"Start is in sight at {size}, before any scrolling", 10.0)


def is_on_top(button: Locator) -> bool:
    """Whether a press on any corner of it would meet it."""
    return button.evaluate("""one => {
        const { left, right, top, bottom } = one.getBoundingClientRect();
        const corners = [[left + 8, top + 8], [right - 8, top + 8], [left + 8, bottom - 8], [right - 8, bottom - 8]];
        return corners.every(at => one.contains(document.elementFromPoint(...at)));
    }""")


def test_a_viewer_is_not_asked_to_go_on_with_a_calibration(visit: Open, console: Running) -> None:
    console.ask("api/calibration/sessions", {"kind": "camera", "board": {"columns": 9, "rows": 6, "square_m": 0.03}})
    here = visit(watching=True, at="calibrate")
    expect(here.find(".begun")).to_contain_text("Calibrations to look at", timeout=SOON)
    expect(here.find(".home-foot")).to_be_hidden()


def test_stop_is_in_reach_on_the_wizards_page_and_a_viewer_may_press_it(visit: Open, console: Running) -> None:
    console.ask("api/commands", {"text": "turn left"})
    here = visit(size=PHONE, watching=True, at="calibrate")
    page = here.page
    expect(here.find(".wizard-card").first).to_contain_text("You are watching", timeout=SOON)
    expect(page.get_by_role("button", name="Begin", exact=True)).to_have_count(0)
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    stop = here.button("STOP")
    box = stop.bounding_box()
    assert box is not None
    assert box["y"] + box["height"] <= PHONE[1]
    stop.click()
    here.until(lambda: console.newest()["state"] != "running", "the robot was stopped", 5.0)
    here.still()
    console.ask("api/lease", {"do": "release"})
