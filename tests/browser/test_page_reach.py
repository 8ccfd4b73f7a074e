"""STOP in reach at every size and over everything, the page by keys alone, themes, signing in, a recording."""

import re
import time
from collections.abc import Callable
from functools import partial

import pytest
from playwright.sync_api import Browser, Locator, Page, expect

from tests.browser.running_console import Running, write_log
from tests.browser.visit import DESK, PATIENCE, PHONE, Visit

Open = Callable[..., Visit]
SMALLEST = 64  # [px] of STOP
OTHER_SIZES = [pytest.param(size, marks=pytest.mark.campaign) for size in (DESK, (360, 640))]


def stop_is_free(here: Visit) -> bool:
    """Whether a finger on any part of STOP meets STOP."""
    return here.page.evaluate(
        """least => {
            const { left, top, width, height } = document.querySelector(".stop").getBoundingClientRect();
            if (Math.min(width, height) < least || left < 0 || top < 0) return false;
            if (left + width > innerWidth || top + height > innerHeight) return false;
            return [0.1, 0.5, 0.9].every((x) => [0.1, 0.5, 0.9].every((y) =>
                document.elementFromPoint(left + x * width, top + y * height)?.closest(".stop")));
        }""",
        SMALLEST,
    )


@pytest.mark.parametrize("size", [PHONE, (844, 390), *OTHER_SIZES])
def test_stop_is_large_and_free_whatever_is_open(visit: Open, size: tuple[int, int]) -> None:
    here = visit(size=size, hints=True)
    expect(here.find(".coach")).to_be_visible()
    for _ in range(5):
        assert stop_is_free(here)
        here.find("coach-marks .coach-foot button").last.click()
    for opener in ("link-chip button", "lease-chip button", "app-menu button"):
        here.find(opener).first.click()
        assert stop_is_free(here), opener
        here.find(opener).first.click()
    for tab in here.find(".view-tab").all():
        if tab.is_visible():
            tab.click()
            assert stop_is_free(here)
    here.page.keyboard.press("?")
    assert here.find("key-sheet").is_visible()
    assert stop_is_free(here)
    assert here.page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_on_a_phone_no_menu_and_no_dialog_lies_under_stop(visit: Open) -> None:
    here = visit(size=PHONE)
    stop = here.find(".stop").bounding_box()
    assert stop is not None
    here.find("app-menu button").first.click()
    for opened in ("app-menu .popover", "settings-sheet .sheet", "key-sheet .sheet"):
        box = here.find(opened).bounding_box()
        assert box is not None and box["y"] + box["height"] <= stop["y"], opened
        here.page.keyboard.press("Escape")
        name = "show-settings" if "menu" in opened else "show-keys"
        here.page.evaluate(f"dispatchEvent(new CustomEvent('{name}'))")


def test_a_phones_map_is_covered_by_the_newest_notice_alone_and_no_banner_halves_a_button(
    visit: Open, console: Running
) -> None:
    here = visit(size=PHONE)
    switch = here.find(".stage > map-switch")
    expect(switch).to_be_visible()
    console.ask("api/halt", {})
    expect(here.find(".banner[data-banner=halted]")).to_be_visible()
    expect(switch).to_be_hidden()
    here.find(".banner[data-banner=halted] button").click()
    expect(switch).to_be_visible()
    notices = here.find("notice-toasts")
    notices.evaluate("""all => all.append(...["one", "two"].map(words => {
        const toast = document.createElement("div");
        [toast.className, toast.dataset.level, toast.textContent] = ["toast", "info", words];
        return toast;
    }))""")
    expect(notices.get_by_text("two", exact=True)).to_be_visible()
    expect(notices.get_by_text("one", exact=True)).to_be_hidden()


def test_the_bar_ends_before_stop_in_german_too(visit: Open) -> None:
    german = "localStorage.setItem('beckon.language', 'de')"
    others = [visit(size=(1200, 800), before=lambda page: page.add_init_script(german)) for _ in range(2)]
    for width in (1030, 1200, 1280, 1440):
        others[0].page.set_viewport_size({"width": width, "height": 800})
        menu, stop = (others[0].find(part).bounding_box() for part in ("app-menu", "stop-button"))
        assert menu and stop and menu["x"] + menu["width"] <= stop["x"], width


def test_a_phones_bar_is_whole_without_a_link_in_german_too(visit: Open) -> None:
    here = visit(
        size=PHONE,
        at="recordings",
        before=lambda page: page.add_init_script("localStorage.setItem('beckon.language', 'de')"),
    )
    here.page.context.set_offline(True)
    try:
        expect(here.find("link-chip .link-text")).to_have_text("getrennt")
        menu = here.find("app-menu").bounding_box()
        assert menu and menu["x"] + menu["width"] <= PHONE[0]
        assert here.page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    finally:
        here.page.context.set_offline(False)
    expect(here.find("link-chip .link-text")).not_to_have_text("getrennt")
    here.complaints.clear()  # of files that could not be had


def test_on_a_phones_side_nothing_lies_under_stop_and_words_are_offered_in_sight(visit: Open) -> None:
    german = "localStorage.setItem('beckon.language', 'de')"
    here = visit(size=(844, 390), before=lambda page: page.add_init_script(german))
    shown = here.find("command-chips .chip:not([data-over], .more):visible")
    here.until(lambda: shown.count() >= 5, "most commands are in sight")
    boxes = [box for one in shown.all() if (box := one.bounding_box())]
    assert len({round(box["y"]) for box in boxes}) == 2, "two rows, in German too"
    here.find("#words").fill("stop")
    offered = here.find(".suggestions").bounding_box()
    assert offered and offered["y"] > 0 and offered["y"] + offered["height"] <= 390
    here.find("#words").fill("")
    here.find("app-menu button").first.click()
    stop = here.find("stop-button").bounding_box()
    menu = here.find("app-menu .popover").bounding_box()
    assert stop and menu and menu["x"] + menu["width"] <= stop["x"]
    here.page.keyboard.press("Escape")
    here.page.evaluate("document.querySelector('app-menu').dispatchEvent(new Event('show-keys', { bubbles: true }))")
    sheet = here.find("key-sheet .sheet").bounding_box()
    assert sheet and sheet["x"] + sheet["width"] <= stop["x"]


def test_every_layer_of_the_map_can_be_pressed_at_every_size(visit: Open) -> None:
    here = visit()
    covered = """() => [...document.querySelectorAll(".flat-layer")].filter((layer) => {
        const { left, top, width, height } = layer.getBoundingClientRect();
        return !layer.contains(document.elementFromPoint(left + width / 2, top + height / 2));
    }).map((layer) => layer.textContent)"""
    for width, height in ((1440, 900), (1366, 650), (820, 1180), (844, 390), (390, 844)):
        here.page.set_viewport_size({"width": width, "height": height})
        here.find(".flat-layers-place > button").click()
        expect(here.find(".flat-layer").last).to_be_visible()
        assert here.page.evaluate(covered) == [], (width, height)
        here.page.keyboard.press("Escape")


SIZES = [(1280, 720), (1030, 640), (1440, 900), (1366, 650), (820, 1180), (844, 390), (720, 450), (390, 844)]
# What an operator looks at: camera whole, tabs beside it and not over it, a map to press, STOP, status, words.
WHOLE = """() => {
  const place = (part) => document.querySelector(part).getBoundingClientRect();
  const [picture, box] = [place(".picture"), place(".picture-box")];
  const hit = (x, y) => document.elementFromPoint(picture.left + x * picture.width, picture.top + y * picture.height);
  const [ends, seen] = [[0.02, 0.5, 0.98], ".picture-box, command-status"];
  const meets = ends.every((x) => ends.every((y) => hit(x, y)?.closest(seen)));
  const inside = picture.top >= box.top - 1 && picture.bottom <= box.bottom + 1 && picture.right <= box.right + 1;
  const over = (one, other) => Math.max(0, Math.min(one.right, other.right) - Math.max(one.left, other.left))
    * Math.max(0, Math.min(one.bottom, other.bottom) - Math.max(one.top, other.top));
  const [stage, tabs] = [place(".over"), place("tab-card")]; // what no panel covers
  return { meets, inside, height: picture.height, ratio: picture.width / picture.height, words: words.clientWidth,
    map: Math.min(stage.width, stage.height), covered: over(tabs, place("camera-view")) + over(tabs, stage),
    tabs: tabs.height, low: tabs.bottom <= innerHeight && stage.bottom <= innerHeight };
}"""


def is_whole(here: Visit) -> bool:
    """Whether the picture is drawn, within its box, and nothing lies over it: notices of a busy machine leave."""
    seen = here.page.evaluate(WHOLE)
    return seen["ratio"] > 0 and seen["meets"] and seen["inside"]


def test_the_camera_is_whole_and_the_status_readable_at_every_size(visit: Open) -> None:
    here = visit(size=SIZES[0])
    for width, height in SIZES:
        here.page.set_viewport_size({"width": width, "height": height})
        tabs = here.button("Camera")
        if tabs.is_visible():
            tabs.click()
        expect(here.find(".picture")).to_be_visible()
        here.until(partial(is_whole, here), f"the picture is whole and nothing over it at {width}x{height}")
        seen = here.page.evaluate(WHOLE)
        assert abs(seen["ratio"] - 1.25) < 0.02, (width, height, seen)
        assert seen["words"] >= 120 and seen["low"] and stop_is_free(here), (width, height, seen)
        if not tabs.is_visible():  # map, camera and tabs at once
            assert min(seen["height"], seen["map"]) >= 200 and seen["tabs"] >= 150, (width, height, seen)
            assert seen["covered"] == 0, (width, height, seen)
        before = here.find(".over").bounding_box()
        here.say("turn lift")
        chip = here.find("command-status .suggested button").first
        for part in (here.find(".status-words"), here.find(".status-remark"), chip):
            here.until(partial(at_its_place, part), f"{part} is seen at {width}x{height}")
        assert here.page.evaluate("document.documentElement.scrollWidth <= innerWidth"), (width, height)
        assert here.find(".over").bounding_box() == before, "the map does not jump"


def test_a_press_exchanges_camera_and_map_and_tabs_are_a_tablist(visit: Open) -> None:
    here = visit(size=(1280, 650))
    stage, camera = here.find(".stage"), here.find("camera-view")

    def across(part: Locator) -> float:
        box = part.bounding_box()
        return box["width"] if box else 0.0

    small = across(camera)
    here.button("Large camera").click()
    assert across(camera) > 2 * small and across(stage) == small
    expect(camera).to_have_css("background-color", "rgb(11, 15, 20)")  # in the light theme, too
    expect(here.find("command-status")).to_be_visible()
    here.page.reload()
    here.until(lambda: across(stage) == small, "it is remembered")
    here.button("Large map").click()
    assert across(camera) == small
    expect(here.page.get_by_role("tab", name="Voices", exact=True)).to_be_visible()  # with the first state
    here.page.get_by_role("tab", name="History", exact=True).focus()
    for key, name in (("ArrowRight", "Estimate"), ("ArrowRight", "Voices"), ("End", "Notices"), ("Home", "History")):
        here.page.keyboard.press(key)
        tab = here.page.get_by_role("tab", name=name, exact=True)
        expect(tab).to_be_focused()
        expect(tab).to_have_attribute("aria-selected", "true")
        expect(here.page.get_by_role("tabpanel", name=name)).to_be_visible()
    here.find(".where").click()
    expect(here.page.get_by_role("tabpanel", name="Estimate")).to_contain_text("Where it believes it is")
    more, last = here.button("more"), here.find('[data-command="stop_moving"]')
    expect(last).to_be_hidden()
    more.click()
    expect(last).to_be_in_viewport(ratio=1)
    here.page.keyboard.press("Escape")
    here.page.set_viewport_size({"width": DESK[0], "height": DESK[1]})
    more.click()
    expect(last).to_be_in_viewport(ratio=1)
    line = here.find("#words").bounding_box()
    first = here.find('[data-command="turn_left"]').bounding_box()
    assert line and first and first["y"] > line["y"], "where they were, below the line of words"
    here.page.keyboard.press("Escape")
    expect(last).to_be_hidden()


MAGENTA = """() => {
    const picture = document.querySelector("canvas.picture");
    const { data } = picture.getContext("2d").getImageData(0, 0, picture.width, picture.height);
    let count = 0;
    for (let i = 0; i < data.length; i += 4)
        count += data[i] > 150 && data[i + 1] < 130 && data[i + 2] > 150 && data[i + 2] > 1.5 * data[i + 1];
    return count;
}"""  # of the planned way's colour, in pixels; nothing in the simulated room has it


def floor_below(here: Visit, u: float, v: float) -> dict[str, float]:
    """What the console says of a pixel of the newest picture."""
    return here.console.ask(f"api/camera/floor?u_px={u}&v_px={v}&stamp_s={here.console.stamp()}")


def on_page(here: Visit, u: float, v: float) -> tuple[float, float]:
    """Where a pixel of the 320x256 picture is on the page."""
    box = here.find("canvas.picture").bounding_box()
    assert box is not None
    return box["x"] + (u + 0.5) * box["width"] / 320, box["y"] + (v + 0.5) * box["width"] / 320


def goal_of_newest(here: Visit) -> tuple[float, float]:
    numbers = here.console.newest()["numbers"]
    return numbers["x_m"], numbers["y_m"]


def test_a_press_on_the_floor_of_the_large_picture_sends_the_robot_there(visit: Open) -> None:
    here = visit()
    here.still()
    picture, newest = here.find("canvas.picture"), here.console.newest()["id"]
    expect(picture).to_have_attribute("role", "img")
    here.page.mouse.click(*on_page(here, 160, 185))
    assert here.console.newest()["id"] == newest, "a press on the small picture exchanges picture and map"
    expect(here.find(".console")).to_have_attribute("data-big", "camera")
    expect(picture).to_have_attribute("role", "application")

    here.page.mouse.click(*on_page(here, 160, 60))
    expect(here.find("notice-toasts")).to_contain_text("press the floor")
    assert here.console.newest()["id"] == newest
    floor = floor_below(here, 160, 185)
    assert 0.5 < floor["distance_m"] < 2
    here.page.mouse.click(*on_page(here, 160, 185))
    here.until(lambda: here.console.newest()["id"] > newest, "the command is there")
    assert here.console.newest()["source"] == "camera"
    assert goal_of_newest(here) == pytest.approx((floor["x_m"], floor["y_m"]), abs=0.03)
    here.until(lambda: here.page.evaluate(MAGENTA) > 100, "its way is drawn on the floor")
    camera = here.console.ask("api/state")["camera"]
    assert sum(map(len, camera["way"])) <= 30
    here.button("Way").click()
    here.until(lambda: here.page.evaluate(MAGENTA) == 0, "the way can be left out")
    here.button("Way").click()
    expect(here.find("history-list .record-meta").first).to_contain_text("camera’s picture")
    here.say("stop moving")
    here.still()
    here.until(lambda: "way" not in here.console.ask("api/state")["camera"], "nothing is planned any more")
    here.button("Small camera").click()
    expect(picture).to_have_attribute("role", "img")
    expect(picture).not_to_have_attribute("tabindex", "0")
    assert not here.complaints


def test_the_floor_of_the_picture_is_pressed_by_keys_too(visit: Open) -> None:
    here = visit()
    here.still()
    newest = here.console.newest()["id"]
    here.button("Large camera").click()
    expect(here.find("canvas.picture")).to_have_attribute("role", "application")
    here.page.keyboard.press("Shift+Tab")
    here.find("canvas.picture").focus()
    here.page.keyboard.press("ArrowDown")
    expect(here.find("live-region")).to_contain_text("from the robot")
    assert here.console.speed() == 0, "the arrows move the point, not the robot"
    here.page.keyboard.press("Enter")
    here.until(lambda: here.console.newest()["id"] > newest, "the command is there")
    assert here.console.newest()["source"] == "camera"
    here.page.keyboard.press("Escape")
    here.still()


def test_a_finger_presses_the_floor_of_a_phones_picture(visit: Open) -> None:
    here = visit(size=PHONE)
    here.still()
    newest = here.console.newest()["id"]
    here.button("Camera").click()
    expect(here.find("canvas.picture")).to_have_attribute("role", "application")
    here.until(lambda: not here.find("notice-toasts .toast").count(), "no notice lies over it")
    here.page.touchscreen.tap(*on_page(here, 160, 180))
    here.until(lambda: here.console.newest()["id"] > newest, "the command is there")
    assert here.console.newest()["source"] == "camera"
    here.find(".stop").tap()
    here.still()


def at_its_place(part: Locator) -> bool:
    """Whether the middle of the first line of it is seen, nothing over it; it may be drawn again meanwhile."""
    return part.evaluate(
        """(part) => {
            part.scrollIntoView({ block: "nearest" });
            const [box] = part.getClientRects();
            if (!box) return false;
            const { left, top, width, height } = box;
            const met = document.elementFromPoint(left + width / 2, top + Math.min(height / 2, 8));
            return width > 20 && height > 8 && (part.contains(met) || met?.contains(part));
        }"""
    )


NO_WEBGL = """(() => {
  const own = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
    return kind.startsWith("webgl") ? null : own.call(this, kind, ...more);
  };
})()"""


def test_without_webgl_the_map_is_flat_pressed_measured_and_read_aloud(visit: Open, console: Running) -> None:
    here = visit(before=lambda page: page.add_init_script(NO_WEBGL))
    expect(here.find(".flat-why")).to_contain_text("no WebGL 2")
    here.find(".flat-why").get_by_role("button", name="Dismiss").click()
    expect(here.find(".flat-why")).to_be_hidden()
    expect(here.button("3-D")).to_be_disabled()
    assert here.find("#scene").get_attribute("src") is None and not here.find("scene-view").is_visible()
    floor, words = here.find(".flat-floor"), here.find("#flat-map-words")
    expect(words).to_contain_text("Nearest obstacle")
    expect(words).to_contain_text("The map is")
    here.button("Measure a distance").click()
    for x in (200, 300):
        floor.click(position={"x": x, "y": 300})
    expect(here.find("flat-map [role=status]")).to_have_text(re.compile(r"^\d\.\d\d m$"))
    here.button("Measure a distance").click()
    here.button("Layers").click()
    here.page.get_by_label("Laser", exact=True).uncheck()
    here.button("Layers").click()
    before = console.newest()["id"]
    floor.click(position={"x": 400, "y": 260})
    here.until(lambda: console.newest()["id"] > before, "the press was heard")
    assert (console.newest()["source"], console.newest()["name"]) == ("click", "stop_at")
    expect(here.find("history-list .record-words").first).to_have_text(re.compile("^go to [0-9−]"))  # not “stop at”
    here.button("STOP").click()
    here.still()
    before = console.newest()["id"]
    floor.focus()
    for key in ("ArrowUp", "ArrowUp", "ArrowRight"):
        here.page.keyboard.press(key)
    expect(here.find("flat-map [role=status]")).to_contain_text("from the robot")
    assert max(abs(console.speed()), abs(console.turning())) < 0.01, "the arrow keys belong to the map now"
    here.page.keyboard.press("Enter")
    here.until(lambda: console.newest()["id"] > before, "Enter was heard")
    assert console.newest()["source"] == "click"
    here.button("STOP").click()
    here.still()


def test_a_3d_map_that_keeps_the_page_from_driving_gives_way_to_the_flat_one(visit: Open) -> None:
    here = visit()
    expect(here.find("flat-map")).to_be_visible()  # until the other one draws
    here.page.evaluate("dispatchEvent(new CustomEvent('page-busy'))")  # as the deadman says it
    expect(here.find(".flat-why")).to_contain_text("too busy to drive")
    here.page.reload()
    expect(here.find("flat-map")).to_be_visible()
    here.button("3-D").click()  # chosen: it is not overruled
    here.page.evaluate("dispatchEvent(new CustomEvent('page-busy'))")
    expect(here.find("flat-map")).to_be_hidden()


@pytest.mark.campaign
def test_a_3d_map_that_is_slow_only_while_the_robot_moves_gives_way_too(visit: Open) -> None:
    paced = """if (location.pathname.startsWith("/scene/"))
        window.requestAnimationFrame = (draw) => setTimeout(() => draw(performance.now()), parent.slow ? 300 : 16);"""

    def draws(page: Page) -> None:
        page.add_init_script(f"sceneIsShown = true; {paced}")
        page.route("**/scene/**", lambda route: route.fulfill(body="<canvas></canvas>", content_type="text/html"))

    here = visit(before=draws)
    here.wait(11.0)  # until it was judged at rest
    expect(here.find("flat-map")).to_be_hidden()
    here.page.evaluate("window.slow = true")
    here.wait(6.0)
    expect(here.find("flat-map")).to_be_hidden()
    here.find("[data-command=turn_left]").click()
    expect(here.find(".flat-why")).to_contain_text("too slow")
    here.page.keyboard.press("Escape")
    here.still()


def test_the_map_of_a_phone_is_flat_until_the_other_is_chosen(visit: Open) -> None:
    here = visit(size=PHONE)
    expect(here.find("flat-map")).to_be_visible()
    assert here.find("#scene").get_attribute("src") is None, "the 3-D map is not even loaded"
    expect(here.find(".flat-why")).to_be_hidden()
    here.button("3-D").click()
    expect(here.find("flat-map")).to_be_hidden()
    expect(here.find("#scene")).to_have_attribute("src", re.compile("scene/"))
    here.button("Flat").click()
    expect(here.find("#scene")).to_have_attribute("src", "about:blank")
    assert here.page.evaluate("localStorage.getItem('beckon.map')") == "flat"


@pytest.mark.parametrize("size", [DESK, PHONE])
def test_a_saved_map_is_read_beside_what_can_be_done_with_it(
    visit: Open, console: Running, size: tuple[int, int]
) -> None:
    console.ask("api/maps", {"name": "laboratory in the east"})
    try:
        here = visit(size=size)
        here.open_tab("Places")
        row = here.find("li.map").filter(has_text="laboratory in the east")
        row.scroll_into_view_if_needed()
        body, acts = row.locator(".map-body").bounding_box(), row.locator(".map-acts").bounding_box()
        assert body is not None and acts is not None
        assert body["width"] > 140 and body["height"] < 100
        assert body["y"] + body["height"] <= acts["y"] or body["x"] + body["width"] <= acts["x"]
    finally:
        console.ask("api/maps/laboratory%20in%20the%20east", method="DELETE")


def test_the_page_can_be_used_by_keys_alone(visit: Open, console: Running) -> None:
    here = visit()
    met: list[str] = []
    for _ in range(60):
        here.page.keyboard.press("Tab")
        name, ringed = here.page.evaluate(
            """() => {
                const at = document.activeElement;
                const style = getComputedStyle(at);
                const told = at.getAttribute("aria-label") || at.labels?.[0]?.textContent;
                const name = told || at.textContent || at.title;
                const ringed = style.outlineStyle !== "none" || at.closest(".is-focused") !== null;
                return [at === document.body ? "" : at.localName + " " + name.trim(), ringed];
            }"""
        )
        if not name:
            break
        assert ringed, name
        assert name.split(" ", 1)[1], name
        met.append(name)
    told = "\n".join(met)
    for wanted in ("Skip to", "Link", "Control", "Theme", "Menu", "STOP", "3-D map", "Tell the robot", "turn left"):
        assert wanted in told, wanted

    def press(what: str) -> None:
        here.find(what).focus()
        here.page.keyboard.press("Enter")

    here.told(lambda: press("[data-command='turn_right']"), "cancelled", then=lambda: press(".stop"))


def test_single_keys_can_be_switched_off_but_escape_cannot(visit: Open, console: Running) -> None:
    here = visit()
    here.find("app-menu button").first.click()
    here.page.get_by_role("switch").click()
    here.page.keyboard.press("Escape")
    here.page.keyboard.down("w")
    here.wait(0.4)
    here.page.keyboard.up("w")
    assert abs(console.speed()) < 0.005
    here.told(lambda: here.say("turn left"), "cancelled", then=lambda: here.page.keyboard.press("Escape"))


def test_the_theme_is_chosen_and_remembered(visit: Open) -> None:
    here = visit(theme="light")
    ground = "getComputedStyle(document.documentElement).backgroundColor"
    light = here.page.evaluate(ground)
    here.find("theme-toggle button").click()
    dark = here.page.evaluate(ground)
    assert dark != light
    here.page.reload()
    expect(here.find("link-chip")).to_contain_text("Hz", timeout=1000 * PATIENCE)
    assert here.page.evaluate(ground) == dark


def test_without_a_login_the_page_asks_for_the_token_and_takes_the_whole_link(
    browser: Browser, console: Running
) -> None:
    context = browser.new_context()
    page = context.new_page()
    page.route("**/scene/**", lambda route: route.abort())
    page.goto(console.url)
    page.get_by_label("Token").fill("wrong")
    page.keyboard.press("Enter")
    expect(page.get_by_role("alert").filter(has_text="token")).to_be_visible()
    page.get_by_label("Token").fill(console.driving)
    page.keyboard.press("Enter")
    expect(page.locator("link-chip")).to_contain_text("Hz", timeout=1000 * PATIENCE)
    page.evaluate("link => { location.href = link }", console.driving)
    until = time.monotonic() + 5
    while page.evaluate("location.hash") and time.monotonic() < until:
        page.wait_for_timeout(50)
    assert page.evaluate("location.href") == console.url
    context.close()


@pytest.mark.campaign
def test_a_recording_is_played_and_cannot_be_driven(
    browser: Browser, visit: Open, tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.mktemp("recording")
    with Running(folder, "--robot", f"log:{write_log(folder / 'corridor.log')}") as playing:
        here = visit(console=playing)
        expect(here.find(".badge[data-kind]")).to_have_text("LOG")
        for absent in ("drive-pad", "command-line", "command-chips", "lease-chip"):
            assert not here.find(absent).is_visible(), absent
        assert playing.ask("api/state")["robot"]["progress"] < 0.01  # it waits for who wants to see it
        stop = here.find(".stop")
        expect(stop).to_contain_text("Pause")
        expect(stop).to_be_disabled()
        here.button("Play the recording").click()
        expect(here.find("first-play")).to_be_hidden()
        expect(stop).to_be_enabled()
        stop.click()
        expect(here.button("Play")).to_be_visible()
        here.page.keyboard.press("Space")
        here.button("Pause").click()
        expect(here.button("Play")).to_be_visible()
        before = here.find(".seek").input_value()
        here.find(".seek").press("ArrowRight")
        here.until(lambda: float(here.find(".seek").input_value()) > float(before), "the slider has moved on")
        here.find(".seek").fill("5000")
        here.until(lambda: abs(playing.ask("api/state")["robot"]["progress"] - 0.5) < 0.1, "half way")
        here.button("2×").click()
        here.until(lambda: playing.ask("api/state")["robot"]["speed"] == 2, "twice as fast")
        here.button("Play").click()
        expect(here.button("Pause")).to_be_visible()
        assert stop_is_free(here)
