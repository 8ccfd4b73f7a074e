"""Driving by hand: what moves the simulated robot, and everything that must make it stand."""

import math
import re
from collections.abc import Callable, Iterator

import pytest
from playwright.sync_api import Page, WebSocketRoute, expect

from core.gate.limits import Limits
from core.gate.trace import check, read_trace
from tests.browser.running_console import Running
from tests.browser.visit import DESK, PATIENCE, PHONE, Visit

Open = Callable[..., Visit]
ON_ITS_SIDE = (844, 390)  # a phone


@pytest.fixture(scope="module", autouse=True)
def lawful(console: Running) -> Iterator[None]:
    """Whatever these tests did, the gate's trace must obey its limits."""
    yield
    assert check(read_trace(console.trace), Limits()) == []


def distance(a: tuple[float, ...], b: tuple[float, ...]) -> float:
    return math.hypot(a[0] - b[0], a[1] - b[1])


@pytest.mark.parametrize("size", [PHONE, (390, 664), (360, 640)])
def test_a_phones_menu_shows_the_language_and_its_commands_take_two_rows(visit: Open, size: tuple[int, int]) -> None:
    here = visit(size=size)
    here.find("app-menu button").first.click()
    menu, language = here.find("app-menu .popover"), here.find("#language").bounding_box()
    box = menu.bounding_box()
    assert box and language and language["y"] + language["height"] <= box["y"] + box["height"]
    hidden = menu.evaluate("one => one.scrollHeight - one.clientHeight")
    assert hidden <= 1 or size != PHONE, "all of it is seen"
    here.page.keyboard.press("Escape")
    here.find(".chip.more").click()
    chips = here.find("command-chips .chips .chip").all()
    boxes = [box for one in chips if (box := one.bounding_box())]
    assert len(boxes) == 8 and len({round(box["y"]) for box in boxes}) == 2
    if size == PHONE:
        assert max(box["x"] + box["width"] for box in boxes) <= size[0]
    here.page.keyboard.press("Escape")
    here.say("sing a song")
    meant = here.find("command-status .suggested > *")
    expect(meant).to_have_count(3)
    boxes = [box for one in meant.all() if (box := one.bounding_box())]
    assert len({round(box["y"] + box["height"] / 2) for box in boxes}) == 1


def test_a_phones_speed_takes_two_lines_and_the_link_keeps_how_quickly_stop_was_answered(visit: Open) -> None:
    here = visit(size=PHONE)
    speed = here.find(".top-speed").bounding_box()
    assert speed and speed["height"] < 45, "Speed 3 | up to 0.18 m/s"
    expect(here.find("command-status")).to_have_text(re.compile("Ready"))
    shown = """() => {
        document.querySelector("pending-command-card").hidden = false;
        return document.querySelector("command-status").checkVisibility({ visibilityProperty: true });
    }"""
    assert here.page.evaluate(shown) is False, "Ready would lie over the map above what waits"
    here.say("continue 1.5 meters")
    expect(here.find(".status-left")).to_contain_text(re.compile(r"m, \d+ s to go"))
    left = here.find(".status-left").bounding_box()
    assert left and left["height"] < 20, "1.5 m, 15 s to go: one line beside its button"
    here.button("STOP").click()
    here.find("link-chip button").click()
    expect(here.find("link-chip .pairs")).to_contain_text(re.compile(r"Your last STOP\s*answered after \d+ ms"))


def test_a_phone_on_its_side_has_views_of_one_width_names_of_commands_and_what_the_microphone_can_do(
    visit: Open,
) -> None:
    here = visit(size=ON_ITS_SIDE)
    views = here.find(".view-tab")
    widths = [box["width"] for one in views.all() if (box := one.bounding_box())]
    assert len(widths) == 3 and max(widths) - min(widths) <= 1, widths
    bar = here.find(".bar").bounding_box()
    here.find("voice-button > .voice-more").click()
    panel, stop = here.find(".voice-panel").bounding_box(), here.find("stop-button").bounding_box()
    assert bar and panel and stop and panel["y"] >= bar["y"] + bar["height"], "none of it is behind the bar"
    assert panel["y"] + panel["height"] <= ON_ITS_SIDE[1] and panel["x"] + panel["width"] <= stop["x"]
    here.page.keyboard.press("Escape")
    here.say("stop at 1.25 and 0.35")
    words = here.find(".status-words")
    expect(words).to_have_text("stop at 1.25 and 0.35")
    assert words.evaluate("one => one.getClientRects().length") == 1, "its name stands in one line"
    here.button("STOP").click()
    here.still()


def test_the_speed_of_a_command_stands_beside_that_of_the_hand_and_the_card_does_not_grow(visit: Open) -> None:
    here = visit(size=DESK)
    pad, speed = here.find("drive-pad"), here.find(".top-speed")
    sizes = (DESK, (1100, 760), (820, 1180), ON_ITS_SIDE, PHONE)

    def heights() -> list[float]:
        found: list[float] = []
        for width, height in sizes:
            here.page.set_viewport_size({"width": width, "height": height})
            here.laid_out()
            found.append((pad.bounding_box() or {"height": 0.0})["height"])
        return found

    expect(speed).to_contain_text("Speed 3")
    standing = heights()
    here.page.set_viewport_size({"width": DESK[0], "height": DESK[1]})
    here.laid_out()
    here.say("continue 3 meters")
    expect(speed).to_contain_text(re.compile(r"by command 0\.10.m/s"))
    assert heights() == standing
    expect(speed).to_contain_text(re.compile(r"0\.18.m/s"))  # that of the hand, as before
    here.button("STOP").click()
    expect(here.find(".top-command")).to_be_hidden()
    here.still()


def test_holding_w_drives_the_robot_and_letting_go_stops_it(visit: Open, console: Running) -> None:
    here = visit()
    start = console.truth()
    here.hold("w", lambda: console.speed() > 0.05, "the robot drives")
    expect(here.find(".lease-text")).to_have_text("You drive")
    here.page.keyboard.up("w")
    here.still()
    assert 0.005 < distance(start, console.truth()) < 1.0
    here.hold("s", lambda: console.speed() < -0.05, "it drives back")
    here.page.keyboard.up("s")
    here.still()


def test_whatever_takes_the_hands_away_stops_and_the_held_key_stays_dead(visit: Open, console: Running) -> None:
    here = visit()
    for end in ("blur", "pagehide", "contextmenu"):
        here.hold("a", lambda: console.turning() > 0.2, "the robot turns")
        here.page.evaluate("name => window.dispatchEvent(new Event(name))", end)
        here.within(2.0, lambda: abs(console.turning()) < 0.01, f"it stands after {end}")
        before = console.truth()[2]
        here.wait(0.4)
        assert abs(console.truth()[2] - before) < 0.02, end
        here.page.keyboard.up("a")


def test_a_key_held_through_stop_does_not_move_the_robot_until_it_is_pressed_anew(
    visit: Open, console: Running
) -> None:
    here = visit()
    here.hold("d", lambda: console.turning() < -0.2, "the robot turns")
    here.page.keyboard.press("Escape")
    here.within(2.0, lambda: abs(console.turning()) < 0.01, "it stands")
    expect(here.find(".drive-why")).to_contain_text("Let go")
    before = console.truth()[2]
    here.wait(0.6)
    assert abs(console.truth()[2] - before) < 0.02
    here.page.keyboard.up("d")
    here.hold("a", lambda: console.turning() > 0.2, "a new press turns it")
    here.page.keyboard.up("a")


def test_a_3d_map_that_is_given_up_takes_neither_the_held_key_nor_the_reason(visit: Open, console: Running) -> None:
    here = visit()
    here.hold("d", lambda: console.turning() < -0.2, "the robot turns")
    here.page.evaluate("dispatchEvent(new CustomEvent('page-busy'))")
    expect(here.find("scene-view")).to_be_hidden()
    here.page.keyboard.press("Escape")
    expect(here.find(".drive-why")).to_contain_text("Let go")
    here.page.keyboard.up("d")


def test_the_stick_drives_while_it_is_held_even_outside_its_ring(visit: Open, console: Running) -> None:
    here = visit()
    ring = here.find(".stick").bounding_box()
    assert ring is not None
    x, y = ring["x"] + ring["width"] / 2, ring["y"] + ring["height"] / 2

    def push() -> None:
        here.page.mouse.move(x, y)
        here.page.mouse.down()
        here.page.mouse.move(x - 400, y)

    here.insist(push, here.page.mouse.up, lambda: console.turning() > 0.2, "the robot turns left")
    here.page.mouse.up()
    here.within(2.0, lambda: abs(console.turning()) < 0.01, "it stands")


def test_a_stick_whose_page_lost_the_hands_stays_dead_until_it_is_pressed_anew(visit: Open, console: Running) -> None:
    here = visit()
    ring = here.find(".stick").bounding_box()
    assert ring is not None
    x, y = ring["x"] + ring["width"] / 2, ring["y"] + ring["height"] / 2

    def push() -> None:
        here.find(".preset[data-preset='2']").click()  # whose focus the press of the stick takes
        here.page.mouse.move(x, y)
        here.page.mouse.down()
        here.page.mouse.move(x - 40, y)
        here.find(".stick").dispatch_event("contextmenu")  # for which a thumb asks that is held still

    here.insist(push, here.page.mouse.up, lambda: console.turning() > 0.1, "the robot turns left")
    here.page.evaluate("window.dispatchEvent(new Event('blur'))")
    here.within(2.0, lambda: abs(console.turning()) < 0.01, "it stands")
    before = console.truth()[2]
    for aside in range(30, 45):
        here.page.mouse.move(x - aside, y)
        here.wait(0.03)
    assert abs(console.truth()[2] - before) < 0.02
    here.page.mouse.up()

    def push_slowly() -> None:
        here.page.keyboard.down("Shift")
        push()

    here.insist(push_slowly, here.page.mouse.up, lambda: console.turning() > 0.05, "a new press turns it")
    expect(here.find(".top-speed")).to_contain_text("slow", ignore_case=True, timeout=1000 * PATIENCE)
    here.page.keyboard.up("Shift")
    here.page.mouse.up()


def test_when_the_link_goes_the_banner_comes_within_a_second_and_the_robot_stands(
    visit: Open, console: Running
) -> None:
    routes: list[WebSocketRoute] = []

    def through(page: Page) -> None:
        def keep(route: WebSocketRoute) -> None:
            routes.append(route)
            route.connect_to_server()

        page.route_web_socket("**/ws", keep)

    here = visit(before=through)
    here.hold("a", lambda: console.turning() > 0.2, "the robot turns")
    routes[-1].close(code=1012, reason="")
    here.within(1.0, lambda: "Link lost" in here.find("banner-stack").inner_text(), "the banner")
    here.within(2.0, lambda: abs(console.turning()) < 0.01, "it stands")
    expect(here.find("link-chip")).to_contain_text("Hz", timeout=1000 * PATIENCE)
    before = console.truth()[2]
    here.wait(0.6)
    assert abs(console.truth()[2] - before) < 0.02
    here.page.keyboard.up("a")


def test_without_a_link_stop_and_halt_say_what_happens_instead(visit: Open, console: Running) -> None:
    routes: list[WebSocketRoute] = []
    cut: list[bool] = []

    def through(page: Page) -> None:
        def keep(route: WebSocketRoute) -> None:
            if cut:
                route.close(code=1012, reason="")
                return
            routes.append(route)
            route.connect_to_server()

        page.route_web_socket("**/ws", keep)
        page.route(re.compile(r"/api/(stop|halt)"), lambda route: route.abort() if cut else route.continue_())

    here = visit(before=through)
    expect(here.find(".quality-chip")).to_have_text(re.compile(r"\S"))  # a verdict has come
    cut.append(True)
    routes[-1].close(code=1012, reason="")
    expect(here.find(".stop")).to_contain_text("no link")
    expect(here.find("banner-stack")).to_contain_text("Link lost")
    expect(here.find("command-status")).to_contain_text("Commands are not sent until it is back.")
    expect(here.find(".picture-age")).to_have_text(re.compile("s old$"))
    expect(here.find(".quality-chip")).to_have_text("Old")
    here.button("STOP no link").click()
    expect(here.find("command-status")).to_contain_text("STOP may not arrive; the robot stops by itself")
    expect(here.find("notice-toasts")).to_contain_text("Stop could not be sent")
    here.find("app-menu button").first.click()
    expect(here.find(".menu").get_by_role("button", name="Reset the halt")).to_be_disabled()
    here.find(".menu").get_by_role("button", name=re.compile("^Halt")).click()
    expect(here.find("notice-toasts")).to_contain_text("Halt could not be sent")
    here.complaints[:] = [each for each in here.complaints if "ERR_FAILED" not in each]


def test_the_menu_halts_and_no_row_turns_into_another(visit: Open, console: Running) -> None:
    here = visit()
    here.find("app-menu button").first.click()
    rows = here.find(".menu .menu-item")
    before = rows.all_inner_texts()
    console.ask("api/halt", {})  # someone else, in this very moment
    expect(here.find(".banner")).to_contain_text("Halted")
    assert rows.all_inner_texts() == before
    here.find(".menu").get_by_role("button", name=re.compile("^Halt")).click()  # still what it says
    here.wait(0.5)
    assert console.ask("api/state")["gate"]["state"] == "halted"
    here.find("app-menu button").first.click()
    here.find(".menu").get_by_role("button", name="Reset the halt").click()
    here.until(lambda: console.ask("api/state")["gate"]["state"] != "halted", "it is reset")


def test_who_only_watches_cannot_drive_but_can_stop(visit: Open, console: Running) -> None:
    driver, watcher = visit(), visit(watching=True)
    expect(watcher.find(".drive-why")).to_contain_text("You are watching")
    watcher.hold("w", lambda: watcher.find(".way[data-way=up]").count(), "the key is down")
    watcher.wait(0.3)
    watcher.page.keyboard.up("w")
    driver.still()
    stop = watcher.button("STOP")  # pressed at once: a page that draws slowly is not waited for, the turn would end
    told = driver.told(lambda: driver.say("turn left"), "cancelled", then=lambda: stop.click(force=True))
    assert "viewer" in told["remark"]
    driver.still()
    watcher.say("stop")
    watcher.until(lambda: console.newest()["words"] == "stop", "who watches may say stop")
    watcher.say("turn left")
    expect(watcher.find("command-status")).to_contain_text("an operator drives it")


def test_control_is_asked_for_and_given_and_who_loses_it_reads_so(visit: Open, console: Running) -> None:
    first, second = visit(), visit(size=PHONE)
    first.find("lease-chip button").first.click()
    first.button("Take control").click()
    expect(first.find(".lease-text")).to_have_text("You drive")
    second.find("lease-chip button").first.click()
    second.find("lease-chip").get_by_role("button", name="Ask for control").click()
    asked = first.find(".banner").filter(has_text="asks for control")
    asked.get_by_role("button", name="Give control").click()
    chip = second.find("lease-chip .bar-chip")
    expect(chip).to_have_attribute("aria-label", "Control: You drive")
    expect(first.find(".banner")).to_have_count(0)  # who gives it knows it
    first.find("lease-chip button").first.click()
    first.find("lease-chip").get_by_role("button", name="Take over").click()
    lost, stage = second.find(".banner").filter(has_text="took control from you"), second.find(".over")
    expect(lost).to_be_visible()
    inner, outer = lost.bounding_box(), stage.bounding_box()
    assert inner and outer and inner["x"] >= outer["x"] and inner["x"] + inner["width"] <= outer["x"] + outer["width"]
    lost.get_by_role("button", name="Dismiss").click()
    expect(lost).to_have_count(0)


@pytest.mark.parametrize("size", [DESK, PHONE])
def test_who_may_not_drive_because_another_does_asks_or_takes_over_right_there(
    visit: Open, console: Running, size: tuple[int, int]
) -> None:
    first, second = visit(), visit(size=size)
    first.find("lease-chip button").first.click()
    first.button("Take control").click()
    status = second.find("command-status")
    expect(status.locator(".status-remark")).to_have_text(re.compile(r"\S drives\.$"))  # its buttons say the rest
    status.get_by_role("button", name="Ask for control").click()
    expect(status.get_by_role("button", name="Ask for control")).to_be_disabled()
    expect(status).to_contain_text(re.compile(r"drives\. Asked: \d+ s to answer\."))
    first.page.set_viewport_size({"width": 390, "height": 844})
    banner = first.find(".banner").filter(has_text="asks for control")
    answers = [banner.get_by_role("button", name=name).bounding_box() for name in ("Give control", "Keep it")]
    assert answers[0] and answers[1] and answers[0]["y"] == answers[1]["y"], "two answers stand side by side"
    banner.get_by_role("button", name="Keep it").click()
    expect(second.find(".toast")).to_have_text(re.compile(r"keeps control\.$"))  # not “…; operator 2 asked for it”
    expect(status.get_by_role("button", name="Ask for control")).to_be_enabled()
    status.get_by_role("button", name="Take over").click()
    expect(second.find("lease-chip .bar-chip")).to_have_attribute("aria-label", "Control: You drive")
    expect(status.get_by_role("button", name="Take over")).to_have_count(0)


def test_taking_over_is_explicit_and_goes_through_a_stand(visit: Open, console: Running) -> None:
    first, second = visit(), visit()
    first.hold("a", lambda: console.turning() > 0.2, "the first operator turns the robot")
    expect(second.find(".lease-text")).to_have_text(re.compile(r"^(?!Nobody)\S.* drives$"))
    second.page.keyboard.down("d")
    expect(second.find(".drive-why")).to_contain_text("Press the wheel")
    second.page.keyboard.up("d")
    second.find("lease-chip button").first.click()
    second.find("lease-chip").get_by_role("button", name="Take over").click()
    expect(second.find(".lease-text")).to_have_text("You drive")
    second.still()
    expect(first.find(".drive-why")).to_contain_text("drives. Press the wheel")
    expect(first.find(".banner").filter(has_text="took control from you")).to_be_visible()
    assert first.find(".toast").filter(has_text="took over").count() == 0, "one message for one event"
    second.hold("d", lambda: console.turning() < -0.2, "the second operator turns it")
    second.page.keyboard.up("d")
    first.page.keyboard.up("a")
