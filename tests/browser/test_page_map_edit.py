"""The map is edited on the page by mouse, finger and keys, and each edit is taken back; maps of Nav2 are taken in."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import expect

from core.pipelines.nav2_map import pgm
from tests.browser.running_console import Running
from tests.browser.test_page_places import shown
from tests.browser.visit import PHONE, Visit

Open = Callable[..., Visit]


@pytest.fixture(autouse=True)
def _no_edits_stay(console: Running) -> Iterator[None]:
    yield
    if console.ask("api/map/edits")["version"]:
        console.ask("api/map/edits/back", {"version": 0})
    for place in console.ask("api/places")["places"]:
        console.ask(f"api/places/{place['name']}", method="DELETE")


def opened(here: Visit, console: Running) -> Visit:
    """The page of maps."""
    here.page.goto(f"{console.url}maps")
    expect(here.find("link-chip")).to_contain_text("Hz")
    return here


def holding(console: Running) -> list[str]:
    return [one["kind"] for one in console.ask("api/map/edits")["edits"] if one["holds"]]


def stroke(here: Visit, *points: tuple[float, float]) -> None:
    """Drag over the map; shares of its width and height."""
    box = here.find(".map-edit-floor").bounding_box()
    assert box is not None
    spots = [(box["x"] + x * box["width"], box["y"] + y * box["height"]) for x, y in points]
    here.page.mouse.move(*spots[0])
    here.page.mouse.down()
    for spot in spots[1:]:
        here.page.mouse.move(*spot, steps=4)
    here.page.mouse.up()


def test_cells_are_drawn_and_erased_a_room_is_named_and_all_is_taken_back(visit: Open, console: Running) -> None:
    here = opened(visit(), console)
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
    here.find("map-editor").get_by_role("button", name="Undo", exact=True).first.click()
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
    here = opened(visit(size=PHONE), console)
    floor = here.find(".map-edit-floor")
    floor.scroll_into_view_if_needed()
    expect(here.find("map-editor").get_by_role("button", name="Erase")).to_be_enabled()
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


def test_a_map_of_nav2_is_taken_in_and_a_bad_one_is_explained(visit: Open, console: Running, tmp_path: Path) -> None:
    here = opened(visit(), console)
    card = here.find("nav2-card")
    card.scroll_into_view_if_needed()
    told = "image: map.pgm\nresolution: 0.05\norigin: [-2.0, -2.0, 0.0]\nnegate: 0\n"
    (tmp_path / "map.yaml").write_text(told + "occupied_thresh: 0.65\nfree_thresh: 0.196\n")
    cells = np.full((80, 80), 254, np.uint8)
    cells[[0, -1]], cells[:, [0, -1]] = 0, 0
    (tmp_path / "map.pgm").write_bytes(pgm(cells))
    card.get_by_label("YAML and picture, or a zip").set_input_files([tmp_path / "map.yaml", tmp_path / "map.pgm"])
    card.get_by_label("Name", exact=True).fill("from nav2")
    card.get_by_role("button", name="Take in").click()
    here.until(lambda: "from nav2" in [one["name"] for one in console.ask("api/maps")["maps"]], "it is kept")
    console.ask("api/maps/from%20nav2", method="DELETE")
    card.get_by_label("YAML and picture, or a zip").set_input_files([tmp_path / "map.yaml"])
    card.get_by_label("Name", exact=True).fill("half")
    card.get_by_role("button", name="Take in").click()
    expect(card.get_by_role("alert")).to_contain_text("one of them is missing")
    here.complaints[:] = [each for each in here.complaints if "422" not in each]
