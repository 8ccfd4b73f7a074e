"""How the mapping fares, the maps that are kept, and "I am here", on the page."""

import json
import math
import urllib.error
import urllib.request
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Route, expect

from tests.browser.running_console import Running
from tests.browser.visit import PHONE, Visit

Open = Callable[..., Visit]


def drawn(here: Visit, name: str) -> str:
    """The path of a plot's line."""
    plot = here.find("live-plot:visible").filter(has_text=name)
    return plot.locator(".plot-line").get_attribute("d") or ""


def entries(console: Running, what: str) -> list[Any]:
    return [entry["words"] for entry in console.ask("api/audit")["entries"] if entry["what"] == what]


def test_error_surprise_and_update_time_are_drawn_with_axes_to_read(visit: Open) -> None:
    here = visit()
    here.open_tab("SLAM")
    for name in ("True error", "Surprise (NIS)", "Time of an update"):
        here.until(lambda name=name: drawn(here, name).count("L") > 5, f"{name} has a line")
    error = here.find("live-plot:visible").filter(has_text="True error")
    expect(error.locator(".plot-value")).to_contain_text("cm")
    assert error.locator(".plot-claim").get_attribute("d")
    words = error.locator(".plot-words text").all_text_contents()
    assert {"0", "now", "−60 s"} <= set(words)
    assert "two minutes" in (error.locator("svg").get_attribute("aria-label") or "")
    band = here.find("live-plot:visible").filter(has_text="NIS").locator(".plot-band")
    assert float(band.get_attribute("height") or 0) > 3
    expect(here.find("slam-card .landmarks tbody tr").first).to_be_attached()
    expect(here.find("slam-card")).to_contain_text("None yet")


def test_a_map_is_saved_replaced_taken_along_and_deleted(visit: Open, console: Running) -> None:
    here = visit()
    here.open_tab("Places")
    here.find("map-card input").fill("../etc")
    here.button("Save").click()
    expect(here.find("map-card .map-trouble")).to_contain_text("letters, digits")
    here.find("map-card input").fill("my lab")
    here.button("Save").click()
    row = here.find("map-card li.map").filter(has_text="my lab")
    expect(row).to_contain_text("in use")
    expect(row).to_contain_text("landmarks")
    row.get_by_role("button", name="Load my lab").click()
    expect(row).to_contain_text("The present map is saved")  # the robot has not moved since
    row.get_by_role("button", name="Cancel").click()
    row.get_by_role("button", name="Load my lab").click()
    row.get_by_role("button", name="Load it", exact=True).click()
    expect(row).to_contain_text("Loaded. The robot knows where it is on this map.")
    expect(here.find(".map-now")).to_contain_text("my lab")
    here.until(lambda: row.locator("img").evaluate("image => image.naturalWidth > 20"), "its picture is shown")
    here.button("Replace").click()
    here.until(lambda: entries(console, "map").count("save my lab") == 2, "it was replaced")
    expect(row).to_have_count(1)
    for link in (*here.find("map-card .map-file").all(), row.locator("a")):
        with here.page.expect_download() as download:
            link.click()
        assert download.value.failure() is None
    assert console.ask("api/maps")["current"] == "my lab"
    row.get_by_role("button", name="Delete my lab").click()
    row.get_by_role("button", name="Cancel").click()
    row.get_by_role("button", name="Delete my lab").click()
    row.get_by_role("button", name="Delete", exact=True).click()
    expect(row).to_have_count(0)
    expect(here.find(".map-now")).to_contain_text("not saved")


def test_a_list_that_is_read_meanwhile_takes_no_refusal_away(visit: Open) -> None:
    here = visit()
    late: list[Route] = []
    here.page.route("**/api/maps", lambda route: late.append(route))
    here.open_tab("Places")
    here.until(lambda: late, "the list of maps was asked for")
    here.find("map-card input").fill("../etc")
    here.button("Save").click()
    with here.page.expect_response("**/api/maps"):
        late[0].continue_()
    here.page.unroute("**/api/maps")
    here.wait(0.3)
    expect(here.find("map-card .map-trouble")).to_contain_text("letters, digits")


def test_a_robot_that_lost_its_place_claims_no_accuracy(visit: Open) -> None:
    here = visit()
    expect(here.find("estimate-line")).to_contain_text("mm")
    lost = """name => {
        const panel = document.querySelector(name), state = structuredClone(panel.session.state);
        state.floor.lost = { candidates: [] };
        panel.show({ ...panel.session.view, state });
        return panel.innerText;
    }"""
    for name in ("estimate-line", "estimate-card"):
        words = here.page.evaluate(lost, name)
        assert words.count("± ?") == 3 and "mm" not in words and "lost" in words.lower(), words


def test_where_a_lost_robot_may_be_is_marked_on_the_map_and_nothing_lies_over_placing_it(visit: Open) -> None:
    here = visit()
    expect(here.find("estimate-line")).to_contain_text("mm")
    place = {"x_m": 1.0, "y_m": 0.5, "heading_rad": 0.7}
    changed = here.page.evaluate(
        """place => {
            const map = document.querySelector("flat-map"), canvas = map.querySelector("canvas");
            const { view } = map.session;
            const shown = candidates => {
                const state = structuredClone(view.state);
                state.floor.lost = { phase: "asking", words: "Where am I?", candidates };
                map.show({ ...view, state });
                return canvas.toDataURL();
            };
            return shown([]) !== shown([place]);
        }""",
        place,
    )
    assert changed, "the place is drawn"
    here.open_tab("SLAM")
    here.button("It is here…").click()
    expect(here.find("place-view")).to_be_visible()
    expect(here.find("command-status")).to_be_hidden()
    covered = """() => {
        const stack = document.querySelector("banner-stack"), state = structuredClone(stack.session.view.state);
        state.floor.lost = { phase: "asking", words: "Where am I?", candidates: [] };
        stack.show({ ...stack.session.view, state });
        return stack.querySelector('[data-banner="localization"]').checkVisibility();
    }"""
    assert here.page.evaluate(covered) is False, "its banner would cover its words"


def test_the_robot_is_shown_where_it_is_by_press_and_drag(visit: Open, console: Running) -> None:
    here = visit(size=PHONE)
    here.open_tab("SLAM")
    here.button("It is here…").click()
    view = here.find("place-view")
    expect(view).to_be_visible()
    put = here.button("It is here")
    expect(put).to_be_disabled()
    box = here.find(".place-floor").bounding_box()
    assert box is not None
    x, y = box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]
    here.page.mouse.move(x, y)
    here.page.mouse.down()
    here.page.mouse.move(x, y - 60)  # up the drawing: +y
    here.page.mouse.up()
    heading = view.get_by_label("heading in degrees")
    expect(heading).to_have_value("90")
    told = view.get_by_label("x in metres").input_value(), view.get_by_label("y in metres").input_value()
    assert all(math.isfinite(float(value)) for value in told)
    there = console.truth()
    heading.fill(f"{math.degrees(there[2]):.0f}")
    view.get_by_label("x in metres").fill(f"{there[0] + 0.02:.2f}")
    view.get_by_label("y in metres").fill(f"{there[1]:.2f}")
    put.click()
    expect(view).to_be_hidden()
    told = entries(console, "here")[0].removeprefix("I am at ").split(" and ")
    assert [float(value) for value in told] == pytest.approx([there[0] + 0.02, there[1]], abs=0.0051)
    here.until(lambda: console.ask("api/state")["floor"]["lost"] is None, "it fits there")


def test_who_watches_sees_all_of_it_and_changes_nothing(visit: Open, console: Running) -> None:
    here = visit(watching=True)
    here.open_tab("Places")
    expect(here.find("map-card .map-file")).to_have_count(8)
    expect(here.find("map-card form")).to_be_hidden()
    here.open_tab("SLAM")
    expect(here.find("live-plot:visible").first).to_be_visible()
    expect(here.button("It is here…")).to_be_hidden()
    token = console.watching.partition("#t=")[2]
    asked = urllib.request.Request(
        f"{console.url}api/maps",
        json.dumps({"name": "mine"}).encode(),
        {"authorization": f"Bearer {token}", "content-type": "application/json"},
    )
    with pytest.raises(urllib.error.HTTPError, match="403"):
        urllib.request.urlopen(asked, timeout=60)
