"""A press counts where it began: what arrives between pressing and letting go takes no click away."""

import time
from collections.abc import Callable

import pytest
from playwright.sync_api import Locator, Route, expect

from tests.browser.running_console import Running
from tests.browser.visit import PHONE, Visit

Open = Callable[..., Visit]
HELD_S = 0.8  # four drawings of the page


def held(here: Visit, what: Locator, meanwhile: Callable[[], object]) -> None:
    """Press with the mouse, let something happen, and let go at the same place."""
    what.scroll_into_view_if_needed()
    box = what.bounding_box()
    assert box is not None
    here.page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    here.page.mouse.down()
    meanwhile()
    here.wait(HELD_S)
    here.page.mouse.up()


@pytest.fixture
def place(console: Running) -> Callable[[str, float], object]:
    """Name a place behind the page's back."""
    return lambda name, y: console.ask("api/places", {"name": name, "x_m": 0.8, "y_m": y, "heading_rad": None})


def test_save_is_pressed_while_the_saved_maps_are_read(visit: Open, console: Running) -> None:
    here = visit()
    here.open_tab("Places")
    here.find("map-card input").fill("pressed")
    expect(here.find(".map-now")).to_contain_text("not saved")

    def slowly(route: Route) -> None:
        if route.request.method == "GET":
            time.sleep(2 * HELD_S)
        route.continue_()

    here.page.route("**/api/maps", slowly)
    held(here, here.button("Save"), lambda: console.ask("api/maps", {"name": "another"}))
    here.until(lambda: [one["name"] for one in console.ask("api/maps")["maps"]].count("pressed") == 1, "it is saved")
    for name in ("pressed", "another"):
        console.ask(f"api/maps/{name}", method="DELETE")


def test_a_row_of_a_list_is_pressed_while_the_list_changes(
    visit: Open, console: Running, place: Callable[[str, float], object]
) -> None:
    here = visit()
    here.open_tab("Places")
    place("first", 0.4)
    row = here.find("place-list li").filter(has_text="first")
    held(here, row.get_by_role("button", name="Change first"), lambda: place("a new one", 0.6))
    expect(here.find("place-sheet #place-name")).to_have_value("first")
    expect(here.find("place-list li")).to_have_count(2)  # and what was held back is shown
    for name in ("first", "a new one"):
        console.ask(f"api/places/{name.replace(' ', '%20')}", method="DELETE")


def test_a_button_that_moves_away_is_still_what_was_pressed_unless_the_pointer_leaves(visit: Open) -> None:
    here = visit()
    here.open_tab("Places")
    remember = here.button("Remember this place")
    expect(remember).to_be_enabled()
    down = "document.querySelector('place-list').style.translate = '0 9rem'"
    back = "document.querySelector('place-list').style.translate = ''"
    held(here, remember, lambda: here.page.evaluate(down))
    expect(here.find("place-sheet")).to_be_visible()
    here.button("Close").click()
    here.page.evaluate(back)
    held(here, remember, lambda: here.page.mouse.move(700, 300))  # thought better of it
    expect(here.find("place-sheet")).to_be_hidden()


def test_a_finger_on_a_row_keeps_it_until_the_click(
    visit: Open, console: Running, place: Callable[[str, float], object]
) -> None:
    here = visit(size=PHONE)
    here.open_tab("Places")
    place("first", 0.4)
    change = here.find("place-list li").filter(has_text="first").get_by_role("button", name="Change first")
    change.scroll_into_view_if_needed()
    box = change.bounding_box()
    assert box is not None
    finger = [{"x": box["x"] + box["width"] / 2, "y": box["y"] + box["height"] / 2}]
    touch = here.page.context.new_cdp_session(here.page)
    touch.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": finger})
    place("a new one", 0.6)
    here.wait(0.3)
    touch.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    expect(here.find("place-sheet #place-name")).to_have_value("first")
    for name in ("first", "a new one"):
        console.ask(f"api/places/{name.replace(' ', '%20')}", method="DELETE")


def test_a_tool_beside_a_dialog_is_taken_and_the_next_presses_do_not_drive(visit: Open, console: Running) -> None:
    here = visit()
    before = console.newest()["id"]
    zones = here.button("Draw a zone")
    here.button("Name a place").click()
    box = here.find("flat-map canvas").first.bounding_box()
    assert box is not None
    at = [box["x"] + box["width"] / 2, box["y"] + box["height"] / 2]
    here.page.mouse.click(*at)
    expect(here.find("place-sheet")).to_be_visible()
    there = zones.bounding_box()
    assert there is not None
    here.page.mouse.click(there["x"] + there["width"] / 2, there["y"] + there["height"] / 2)
    expect(here.find("place-sheet")).to_be_hidden()
    expect(zones).to_have_attribute("aria-pressed", "true")
    for x, y in ((0, 0), (40, 0), (40, 40)):
        here.page.mouse.click(at[0] + x, at[1] + y)
    here.button("Done").click()
    expect(here.find("zone-sheet")).to_be_visible()
    assert console.newest()["id"] == before


def test_a_dialog_says_that_it_saves(visit: Open, console: Running) -> None:
    here = visit()
    here.open_tab("Places")
    here.button("Remember this place").click()
    here.find("place-sheet #place-name").fill("slow one")
    held_back: list[Route] = []

    def hold(route: Route) -> None:
        if route.request.method == "POST":
            held_back.append(route)
        else:
            route.continue_()

    here.page.route("**/api/places", hold)
    here.find("place-sheet [type=submit]").click()
    expect(here.find("place-sheet [type=submit]")).to_have_text("Saving…")
    expect(here.find("place-sheet [type=submit]")).to_be_disabled()
    held_back[0].continue_()
    expect(here.find("place-list li")).to_contain_text("slow one")
    console.ask("api/places/slow%20one", method="DELETE")
