"""Places and zones on the page: remembered where the robot is, named and drawn on the map, gone to, removed."""

import os
import re
import urllib.parse
from collections.abc import Callable, Iterator

import pytest
from playwright.sync_api import Locator, Route, expect

from tests.browser.running_console import Running
from tests.browser.visit import DESK, PHONE, Visit

Open = Callable[..., Visit]


@pytest.fixture(autouse=True)
def _no_places_stay(console: Running) -> Iterator[None]:
    yield
    for place in console.ask("api/places")["places"]:
        console.ask(f"api/places/{place['name']}", method="DELETE")
    for zone in console.ask("api/zones")["zones"]:
        console.ask(f"api/zones/{urllib.parse.quote(zone['name'])}", method="DELETE")


def shown(here: Visit, name: str) -> None:
    """Keep a picture for a person to look at, where one is asked for."""
    if folder := os.environ.get("BECKON_PICTURES"):
        here.page.screenshot(path=f"{folder}/{name}.png")


def flat(here: Visit) -> None:
    if not here.find("flat-map").is_visible():
        here.button("Flat").click()
    expect(here.find("flat-map")).to_be_visible()


def test_a_place_is_remembered_completed_gone_to_renamed_and_removed(visit: Open, console: Running) -> None:
    here = visit()
    here.open_tab("Places")
    here.button("Remember this place").click()
    sheet = here.find("place-sheet")
    sheet.get_by_label("Name, as you will say it").fill("bus stop")
    sheet.get_by_role("button", name="Save").click()
    expect(sheet.get_by_role("alert")).to_contain_text("always stops the robot")
    here.complaints[:] = [each for each in here.complaints if "422" not in each]  # the browser notes the refusal
    sheet.get_by_label("Name, as you will say it").fill("the window")
    sheet.get_by_label("Arrive facing").check()
    shown(here, "place-sheet")
    sheet.get_by_role("button", name="Save").click()
    expect(sheet).to_be_hidden()
    row = here.find("place-list:visible li.place").filter(has_text="window")
    expect(row).to_be_visible()
    here.find("#words").fill("go to win")
    expect(here.find("#suggestions")).to_contain_text("go to window")
    here.find("#words").fill("")
    row.get_by_role("button", name="Go to window").click()
    here.until(
        lambda: any(one["heard_as"] == "go to window" for one in console.ask("api/commands/history")["commands"]),
        "it was sent there",
    )
    shown(here, "place-list")
    row.get_by_role("button", name="Change window").click()
    sheet.get_by_label("Name, as you will say it").fill("door")
    sheet.get_by_role("button", name="Save").click()
    door = here.find("place-list:visible li.place").filter(has_text="door")
    expect(door).to_be_visible()
    door.get_by_role("button", name="Remove door").click()
    door.get_by_role("button", name="Remove it?").click()
    expect(door).to_have_count(0)


@pytest.mark.parametrize("hand", ["finger", "keys"])
def test_a_place_is_named_on_the_map(visit: Open, console: Running, hand: str) -> None:
    here = visit(size=PHONE) if hand == "finger" else visit()
    flat(here)
    here.button("Name a place").click()
    floor = here.find(".flat-floor")
    if hand == "finger":
        box = here.find(".over").bounding_box()  # what no panel covers
        assert box is not None
        here.page.touchscreen.tap(box["x"] + 0.45 * box["width"], box["y"] + 0.5 * box["height"])
    else:
        floor.focus()
        floor.press("ArrowRight")
        floor.press("Enter")
    sheet = here.find("place-sheet")
    sheet.get_by_label("Name, as you will say it").fill("kitchen")
    shown(here, f"name-by-{hand}")
    sheet.get_by_label("Name, as you will say it").press("Enter")
    expect(sheet).to_be_hidden()
    here.until(lambda: len(console.ask("api/places")["places"]) == 1, "it is there")
    expect(here.button("Name a place")).to_have_attribute("aria-pressed", "true")  # the next press names another one
    expect(here.find(".flat-mode-bar")).to_have_text(re.compile("“kitchen” is there. Press where the next place is."))
    here.find(".flat-mode-bar").get_by_role("button", name="Done").click()
    expect(here.find(".flat-mode-bar")).to_be_hidden()
    shown(here, f"named-by-{hand}")


def test_who_watches_sees_places_and_changes_none(visit: Open, console: Running) -> None:
    console.ask("api/places", {"name": "sofa"})
    here = visit(watching=True)
    here.open_tab("Places")
    row = here.find("place-list:visible li.place")
    expect(row).to_contain_text("sofa")
    expect(row.get_by_role("button")).to_have_count(0)
    expect(here.find("place-list:visible").get_by_role("button", name="Remember this place")).to_be_hidden()


@pytest.mark.parametrize("hand", ["mouse", "finger", "keys"])
def test_a_zone_is_drawn_on_the_map(visit: Open, console: Running, hand: str) -> None:
    here = visit(size=PHONE) if hand == "finger" else visit()
    flat(here)
    here.button("Draw a zone").click()
    floor = here.find(".flat-floor")
    x = y = 0.0
    box = here.find(".over").bounding_box()  # what no panel covers
    assert box is not None
    if hand == "keys":
        floor.focus()
        for key in ("ArrowUp", "ArrowRight", "ArrowDown"):
            floor.press(f"Shift+{key}")
            floor.press("Enter")
    else:
        for across, down in ((0.3, 0.55), (0.6, 0.55), (0.45, 0.75)):
            x, y = box["x"] + across * box["width"], box["y"] + down * box["height"]
            here.page.touchscreen.tap(x, y) if hand == "finger" else here.page.mouse.click(x, y)
    expect(here.find(".flat-mode-bar")).to_contain_text("3")
    shown(here, f"zone-by-{hand}")
    here.page.mouse.dblclick(x, y) if hand == "mouse" else here.button("Done").click()  # the last corner again
    sheet = here.find("zone-sheet")
    sheet.get_by_label("Name", exact=True).fill(f"hole by {hand}")
    if hand == "mouse":
        sheet.get_by_label("Slow, at most").check()
    sheet.get_by_role("button", name="Save").click()
    expect(sheet).to_be_hidden()
    here.until(lambda: console.ask("api/zones")["zones"], "it holds")
    (zone,) = console.ask("api/zones")["zones"]
    assert zone["kind"] == ("slow" if hand == "mouse" else "keep_out") and len(zone["points_m"]) == 3
    shown(here, f"zone-drawn-by-{hand}")


def test_the_bar_of_a_mode_covers_no_wall_of_the_whole_map(visit: Open) -> None:
    here = visit()
    flat(here)
    here.button("Whole map").click()
    expect(here.find("command-status")).to_be_visible()
    here.button("Draw a zone").click()
    here.laid_out()
    expect(here.find("command-status")).to_be_hidden()  # a press on the floor drives nowhere now
    bar = here.find(".flat-mode-bar").bounding_box()
    assert bar is not None
    walls = """({ x, y, width, height }) => {
        const canvas = document.querySelector(".flat-floor"), fine = canvas.width / canvas.clientWidth;
        const { left, top } = canvas.getBoundingClientRect();
        const at = [fine * (x - left), fine * (y - top), fine * width, fine * height].map(Math.round);
        const copy = new OffscreenCanvas(at[2], at[3]).getContext("2d");
        copy.drawImage(canvas, ...at, 0, 0, at[2], at[3]);
        const { data } = copy.getImageData(0, 0, at[2], at[3]);
        let dark = 0;
        for (let one = 0; one < data.length; one += 4) dark += data[one] < 100 && data[one + 3] > 200;
        return dark;
    }"""
    here.until(lambda: here.page.evaluate(walls, bar) == 0, "the map is below the bar")
    here.button("Cancel").click()
    here.laid_out()
    assert here.page.evaluate(walls, bar) == 0, "what closes moves no map"
    here.button("Whole map").click()
    here.until(lambda: here.page.evaluate(walls, bar) > 50, "without it, the map has all of the height")


@pytest.mark.parametrize("size", [PHONE, (360, 640), (844, 390)])
def test_every_corner_of_a_phones_map_can_be_one_of_a_zone(visit: Open, size: tuple[int, int]) -> None:
    here = visit(size=size)
    flat(here)
    here.button("Draw a zone").click()
    here.laid_out()
    box = here.find(".over").bounding_box()
    assert box is not None
    tools, switch = (here.find(part).bounding_box() for part in (".flat-tools", "map-switch"))
    assert tools is not None and switch is not None
    assert tools["y"] + tools["height"] <= box["y"] + box["height"], "the tools end where the map does"
    free = min(tools["x"], switch["x"]) - box["x"]
    for across, down in ((0.02, 0.02), (0.95, 0.02), (0.95, 0.98), (0.5, 0.98), (0.02, 0.98)):
        x, y = box["x"] + across * free, box["y"] + down * box["height"]
        here.page.touchscreen.tap(x, y) if size[0] < 600 else here.page.mouse.click(x, y)
    expect(here.find(".flat-mode-bar")).to_contain_text("Corners: 5")
    shown(here, f"zone-at-{size[0]}")
    here.button("Undo corner").click()
    expect(here.find(".flat-mode-bar")).to_contain_text("Corners: 4")
    here.button("Cancel").click()
    expect(here.find(".flat-mode-bar")).to_be_hidden()


def build_stops(card: Locator) -> None:
    """Desk and sofa: chosen from the list, dragged into their order, and moved by their buttons."""
    card.get_by_label("Add a stop…").select_option("sofa")
    card.get_by_label("Add a stop…").select_option("desk")
    names = card.locator(".route-stop .place-name")
    names.nth(1).drag_to(names.nth(0))
    expect(card.locator(".route-stop .place-name")).to_have_text(["desk", "sofa"])
    card.get_by_role("button", name="sofa earlier").click()
    expect(card.locator(".route-stop .place-name")).to_have_text(["sofa", "desk"])
    card.get_by_role("button", name="desk earlier").click()


def test_names_of_places_that_are_close_are_all_written(visit: Open, console: Running) -> None:
    names = ["bed", "chair", "lamp", "printer", "shelf", "sofa", "table", "trolley"]
    for number, name in enumerate(names):
        console.ask("api/places", {"name": name, "x_m": 1.0 + 0.03 * number, "y_m": 0.02 * (number % 3)})
    here = visit(before=lambda page: page.add_init_script(WRITTEN))
    flat(here)
    here.until(lambda: set(names) <= set(here.page.evaluate("[...written]")), "each name is on the map")


@pytest.mark.parametrize("size", [DESK, PHONE])
def test_the_names_on_the_plan_of_the_maps_page_can_be_read(
    visit: Open, console: Running, size: tuple[int, int]
) -> None:
    for name, x in (("kitchen", 0.8), ("desk", 0.9)):
        console.ask("api/places", {"name": name, "x_m": x, "y_m": 0.3})
    here = visit(size=size, at="maps")
    sheet = here.find(".maps-page .map-sheet")
    here.until(lambda: sheet.evaluate("one => one.naturalWidth > 0 && one.clientWidth > 0"), "the plan is there")
    drawn = here.page.request.get(str(sheet.evaluate("one => one.src"))).text()
    scale = sheet.evaluate("one => one.clientWidth") / 297
    assert "kitchen" in drawn and "desk" in drawn
    assert float(re.findall(r'font-size="([\d.]+)"', drawn)[0]) * scale >= 13
    shown(here, f"plan-{size[0]}")


WRITTEN = """
    window.written = new Set();
    const write = CanvasRenderingContext2D.prototype.fillText;
    CanvasRenderingContext2D.prototype.fillText = function (words, ...where) {
        written.add(words);
        write.call(this, words, ...where);
    };
"""


def test_a_place_in_a_wall_is_warned_of(visit: Open, console: Running) -> None:
    here = visit()
    here.page.route(
        "**/api/places", lambda route: route.fulfill(status=201, json=NEAR) if posted(route) else route.continue_()
    )
    here.open_tab("Places")
    here.button("Remember this place").click()
    here.find("place-sheet #place-name").fill("niche")
    here.find("place-sheet [type=submit]").click()
    expect(here.find("notice-toasts")).to_contain_text("“niche” is 4.0 cm from a wall: the robot has no room there")


NEAR = {"name": "niche", "x_m": 0.1, "y_m": 0.0, "heading_rad": None, "outline_m": [], "wall_m": 0.04}


def posted(route: Route) -> bool:
    return route.request.method == "POST"


def paused_in_the_status_line(here: Visit) -> None:
    """It names the route, as the card does; pause it there and let it go on."""
    expect(here.find("route-card:visible .route-now")).to_contain_text("waits at desk (1 of 2)")
    pill = here.find("command-status")
    expect(pill).to_contain_text("round waits at desk (1 of 2)")
    rows = pill.get_by_role("button").evaluate_all("all => all.map(each => each.getBoundingClientRect().top)")
    assert len(rows) == 2 and rows[0] == rows[1], "Pause and End route stand beside each other"
    pill.get_by_role("button", name="Pause").click()
    expect(pill).to_contain_text("round paused; next goal: desk")
    toast = here.find(".toast").filter(has_text="Paused by")
    expect(pill).to_contain_text("Paused by")
    assert toast.count() == 0, "the status line says it"
    here.say("trun left")
    expect(pill.locator(".status-remark")).to_contain_text("refused. I know no such command")
    pill.get_by_role("button", name="Go on").click()
    expect(pill).to_contain_text("round waits at desk")
    assert toast.count() == 0


def started_once_no_zone_closes_a_stop(card: Locator, console: Running) -> None:
    """A stop that a zone closes is named before the route begins."""
    around_sofa = [(0.2, -0.2), (0.6, -0.2), (0.6, 0.2), (0.2, 0.2)]
    console.ask("api/zones", {"name": "stairs", "kind": "keep_out", "points_m": around_sofa, "max_speed_m_s": None})
    expect(card.locator("li.place")).to_contain_text("“sofa” lies in “stairs”, which the robot keeps out of.")
    console.ask("api/zones/stairs", method="DELETE")
    expect(card.locator("li.place")).not_to_contain_text("stairs")
    card.get_by_role("button", name="Start round").click()


def test_a_route_is_built_on_the_page_run_paused_and_says_why_it_stands(visit: Open, console: Running) -> None:
    for name, x in (("desk", 0.05), ("sofa", 0.3)):
        console.ask("api/places", {"name": name, "x_m": x, "y_m": 0.0})
    here = visit()
    flat(here)
    here.open_tab("Places")
    card = here.find("route-card:visible")
    card.get_by_role("button", name="New route").click()
    card.get_by_label("Name of the route").fill("round")
    box = here.find(".over").bounding_box()
    assert box is not None
    before = console.newest()["id"]
    here.page.mouse.click(box["x"] + 0.3 * box["width"], box["y"] + 0.55 * box["height"])
    expect(card.get_by_role("alert")).to_contain_text("No place is there")
    build_stops(card)
    assert console.newest()["id"] == before, "a press beside a pin drives nowhere while a route is made"
    card.get_by_label("Action at desk").select_option("wait_for_continue")
    expect(card.get_by_label("Words at sofa")).to_be_hidden()
    card.get_by_label("Action at sofa").select_option("say")
    card.get_by_label("Words at sofa").fill("Tea is ready")
    card.get_by_label("Seconds at sofa").fill("25.5")
    expect(card.get_by_label("Rounds from")).to_be_hidden()
    card.get_by_label("Repeat until someone ends it").check()
    card.get_by_label("Rounds from").fill("00:01")
    card.get_by_label("until", exact=True).fill("00:00")  # all but a minute of the day
    card.get_by_label("Minutes from round to round").fill("5")
    shown(here, "route-built")
    card.get_by_role("button", name="Save").click()
    expect(card.locator("li.place")).to_contain_text("desk → sofa, again and again")
    (route,) = console.ask("api/routes")["routes"]
    assert (route["loop"], route["begins"], route["ends"], route["every_min"]) == (True, "00:01", "00:00", 5.0)
    assert [(one["action"], one["wait_s"], one["text"]) for one in route["stops"]] == [
        ("wait_for_continue", 0.0, ""),
        ("say", 25.5, "Tea is ready"),
    ]
    started_once_no_zone_closes_a_stop(card, console)
    paused_in_the_status_line(here)
    card.get_by_role("button", name="Go on").click()
    expect(card.locator(".route-now")).to_contain_text("sofa (2 of 2)")
    card.get_by_role("button", name="Pause").click()
    expect(card.locator(".route-now")).to_contain_text("paused; next goal: sofa")
    expect(card.locator(".route-under")).to_contain_text("Paused by")
    shown(here, "route-paused")
    card.get_by_role("button", name="End route").click()
    expect(card.locator(".route-now")).to_contain_text("ended; last goal: sofa")
    card.get_by_role("button", name="Change round").click()
    expect(card.get_by_label("Seconds at sofa")).to_have_value("25.5")
    card.get_by_role("button", name="Remove desk").click()
    card.get_by_role("button", name="Save").click()
    expect(card.locator("li.place")).not_to_contain_text("desk")
    (route,) = console.ask("api/routes")["routes"]
    assert [one["place"] for one in route["stops"]] == ["sofa"] and route["every_min"] == 5.0
    card.get_by_role("button", name="Remove round").click()
    card.get_by_role("button", name="Remove it?").click()
    expect(card.locator("li.place")).to_have_count(0)
