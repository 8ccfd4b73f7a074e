"""The map is edited on the page by mouse, finger and keys, and each edit is taken back; maps of Nav2 are taken in."""

import io
import re
import zipfile
from collections.abc import Callable, Iterator

import pytest
from playwright.sync_api import FilePayload, Locator, expect

from core.pipelines.nav2_map import nav2_map
from core.slam.map.occupancy import OccupancyGrid
from tests.browser.running_console import Running
from tests.browser.test_page_places import shown
from tests.browser.visit import PHONE, Visit
from tests.core.slam.test_map_join import floor_plan

Open = Callable[..., Visit]


@pytest.fixture(autouse=True)
def _no_edits_stay(console: Running) -> Iterator[None]:
    yield
    if console.ask("api/map/edits")["version"]:
        console.ask("api/map/edits/back", {"version": 0})
    for place in console.ask("api/places")["places"]:
        console.ask(f"api/places/{place['name']}", method="DELETE")


def holding(console: Running) -> list[str]:
    return [one["kind"] for one in console.ask("api/map/edits")["edits"] if one["holds"]]


def stroke(here: Visit, *points: tuple[float, float]) -> None:
    """Drag over the map; shares of its width and height."""
    floor = here.find(".map-edit-floor")
    floor.scroll_into_view_if_needed()  # what came above it in the meantime has moved it
    box = floor.bounding_box()
    assert box is not None
    spots = [(box["x"] + x * box["width"], box["y"] + y * box["height"]) for x, y in points]
    here.page.mouse.move(*spots[0])
    here.page.mouse.down()
    for spot in spots[1:]:
        here.page.mouse.move(*spot, steps=4)
    here.page.mouse.up()


def test_the_link_to_the_editor_leaves_the_bar_where_it_is(visit: Open) -> None:
    here = visit(at="maps")
    here.page.get_by_role("link", name="Edit the map").click()
    expect(here.find(".map-edit-floor")).to_be_in_viewport()
    here.wait(0.5)
    assert here.page.evaluate("document.documentElement.scrollTop") == 0
    assert here.page.evaluate("document.documentElement.scrollHeight <= innerHeight")


def test_a_saved_map_is_renamed_on_the_page(visit: Open, console: Running) -> None:
    here = visit(at="maps")
    for name in ("lab", "hall"):
        console.ask("api/maps", {"name": name})
    saved = here.find(".map-saved:visible")
    for to in ("hall", "first floor"):
        saved.get_by_role("button", name="Rename lab").click()
        saved.get_by_role("textbox", name="New name of the map").fill(to)
        here.page.keyboard.press("Enter")
        if to == "hall":
            expect(here.find("map-card:visible .map-trouble")).to_contain_text("There is a map “hall” already")
    expect(saved.locator(".map-name")).to_contain_text(["hall", "first floor"])
    assert {one["name"] for one in console.ask("api/maps")["maps"]} >= {"hall", "first floor"}
    here.complaints[:] = [each for each in here.complaints if "409" not in each]  # the browser notes the refusal
    for name in ("hall", "first%20floor"):
        console.ask(f"api/maps/{name}", method="DELETE")


def test_cells_are_drawn_and_erased_a_room_is_named_and_all_is_taken_back(visit: Open, console: Running) -> None:
    here = visit(at="maps")
    floor = here.find(".map-edit-floor")
    floor.scroll_into_view_if_needed()
    expect(here.find("map-editor").get_by_role("button", name="Erase")).to_be_enabled()
    here.button("Draw walls").click()
    stroke(here, (0.3, 0.3), (0.5, 0.5), (0.6, 0.35))
    here.until(lambda: holding(console)[-1:] == ["occupied"], "a wall was drawn")
    here.button("Crop").click()
    stroke(here, (0.1, 0.1), (0.9, 0.9))
    here.until(lambda: holding(console)[-2:] == ["occupied", "crop"], "it was cropped")
    shown(here, "map-editor")
    later = here.find("map-editor").get_by_role("button", name=re.compile("^Undo all edits after"))
    expect(later).to_have_count(1)  # nothing is later than the newest
    later.click()
    here.until(lambda: holding(console)[-1:] == ["occupied"], "the crop was taken back")
    here.button("Name a room").click()
    for x, y in ((0.4, 0.4), (0.6, 0.4), (0.6, 0.6), (0.4, 0.6)):
        stroke(here, (x, y))
    name = here.find("map-editor").get_by_label("Name of the room")
    name.fill("bureau")
    name.press("Enter")
    here.until(
        lambda: [one["name"] for one in console.ask("api/places")["places"]] == ["bureau"], "the room has a name"
    )


def test_a_finger_and_the_keys_draw_too(visit: Open, console: Running) -> None:
    here = visit(size=PHONE, at="maps")
    floor = here.find(".map-edit-floor")
    floor.scroll_into_view_if_needed()
    expect(here.find("map-editor").get_by_role("button", name="Erase")).to_be_enabled()
    here.page.get_by_role("link", name="Edit the map").click()
    seen = "one => one.getBoundingClientRect().bottom <= document.querySelector('.stop').getBoundingClientRect().top"
    here.until(lambda: floor.evaluate(seen), "all of the map is above STOP")
    box = floor.bounding_box()
    assert box is not None
    before = len(holding(console))
    here.page.touchscreen.tap(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    here.until(lambda: len(holding(console)) == before + 1, "a tap erased a spot")
    floor.focus()
    for key in ("ArrowLeft", "Enter", "ArrowLeft", "ArrowUp", "Enter"):
        floor.press(key)
    here.until(lambda: len(holding(console)) == before + 2, "the keys drew a stroke")
    shown(here, "map-editor-phone")


def zipped(grid: OccupancyGrid) -> bytes:
    text, picture = nav2_map(grid)
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as box:
        box.writestr("map.yaml", text)
        box.writestr("map.pgm", picture)
    return packed.getvalue()


def take_in(here: Visit, called: str, file: FilePayload) -> Locator:
    """Give the page a map of Nav2 → its card."""
    card = here.find("nav2-card")
    card.get_by_label("YAML and picture, or a zip").set_input_files(file)
    card.get_by_label("Name", exact=True).fill(called)
    card.get_by_role("button", name="Take in").click()
    return card


def taken_in(here: Visit, called: str, grid: OccupancyGrid) -> None:
    """Give the page a grid as a map, and wait until it can be chosen."""
    take_in(here, called, FilePayload(name="map.zip", mimeType="application/zip", buffer=zipped(grid)))
    expect(here.find("join-card").get_by_label("Newer map")).to_contain_text(called)


def match(here: Visit, older: str, newer: str) -> Locator:
    """Ask where one map lies in another → the card."""
    join = here.find("join-card")
    join.get_by_label("Older map, whose axes stay").select_option(older)
    join.get_by_label("Newer map").select_option(newer)
    join.get_by_role("button", name="Find where they match").click()
    return join


def test_a_map_of_nav2_is_taken_in_and_a_bad_one_or_a_join_is_explained(visit: Open, console: Running) -> None:
    here = visit(at="maps")
    taken_in(here, "from nav2", floor_plan())
    expect(match(here, "from nav2", "from nav2").get_by_role("alert")).to_contain_text("two")
    console.ask("api/maps/from%20nav2", method="DELETE")
    card = take_in(here, "half", FilePayload(name="map.yaml", mimeType="text/yaml", buffer=b"image: map.pgm"))
    expect(card.get_by_role("alert")).to_contain_text("one of them is missing")
    here.complaints[:] = [each for each in here.complaints if "422" not in each]


@pytest.mark.campaign
def test_two_maps_are_shown_over_each_other_and_joined(visit: Open, console: Running) -> None:
    here = visit(at="maps")
    for called, grid in (("whole plan", floor_plan()), ("east part", floor_plan(1, 60))):
        taken_in(here, called, grid)
    join = match(here, "whole plan", "east part")
    expect(join.get_by_role("status")).to_contain_text("views agree", timeout=60_000)
    expect(join.get_by_role("alert")).to_be_hidden()
    here.until(lambda: join.locator("img").evaluate("image => image.naturalWidth > 20"), "both are shown")
    shown(here, "join-card")
    join.get_by_label("Name of the joined map").fill("both")
    join.get_by_role("button", name="Join them").click()
    expect(here.find("map-card li.map").filter(has_text="both")).to_be_visible(timeout=60_000)
    expect(join.get_by_role("status")).to_be_hidden()
    for one in ("both", "whole%20plan", "east%20part"):
        console.ask(f"api/maps/{one}", method="DELETE")
