"""Telling the robot: the line, the buttons, the history, the first hints."""

import json
import re
from collections.abc import Callable

import pytest
from playwright.sync_api import Page, Route, WebSocketRoute, expect

from tests.browser.running_console import Running
from tests.browser.visit import DESK, PATIENCE, PHONE, Visit

Open = Callable[..., Visit]
REFUSE = """() => {
  navigator.mediaDevices.getUserMedia = () => Promise.reject(new DOMException("no", "NotAllowedError"));
}"""


def test_typed_words_run_and_stand_in_the_history_with_their_end(visit: Open, console: Running) -> None:
    here = visit()

    def type_it() -> None:
        here.find("app-menu button").first.focus()
        here.page.keyboard.press("/")
        here.page.keyboard.type("turn le")
        expect(here.page.get_by_role("option")).to_contain_text(["turn left"])
        here.page.keyboard.press("ArrowDown")
        here.page.keyboard.press("Enter")

    assert here.told(type_it, "done")["source"] == "typed"
    row = here.find(".record").first
    expect(row).to_be_visible()
    expect(row).to_contain_text("turn left")
    expect(row.locator(".outcome")).to_have_text("done")
    expect(row).to_contain_text("typed")
    expect(here.find("command-status")).to_contain_text("done")
    here.find("#words").focus()
    here.page.keyboard.press("ArrowUp")
    assert here.find("#words").input_value() == "turn left"


def test_escape_in_the_text_box_stops_what_runs(visit: Open, console: Running) -> None:
    here = visit()

    def begin_another() -> None:
        here.find("#words").press_sequentially("turn")
        here.page.keyboard.press("Escape")

    here.told(lambda: here.say("turn right"), "cancelled", then=begin_another)
    assert here.find("#words").input_value() == "turn"
    expect(here.find("#words")).not_to_be_focused()  # W drives again
    here.still()


def test_a_refusal_is_german_on_a_german_page_and_english_in_the_interface(visit: Open, console: Running) -> None:
    def choose_german(page: Page) -> None:
        page.add_init_script("localStorage.setItem('beckon.language', 'de')")

    here = visit(before=choose_german)
    here.say("continue 99 meters")
    expect(here.find("command-status")).to_contain_text("nimmt x von 0.01 bis 20 Metern.")
    expect(here.find(".record").first).to_contain_text("nimmt")  # the history, too
    expect(here.find(".record .outcome").first).to_have_text("abgelehnt")
    assert "takes" in console.newest()["remark"]


def test_what_is_refused_says_why_and_offers_what_was_meant(visit: Open, console: Running) -> None:
    here = visit()
    here.say("continue 99 meters")
    expect(here.find("command-status")).to_contain_text("refused")
    reason = console.newest()["remark"]
    assert reason
    expect(here.find("command-status")).to_contain_text(reason)
    here.find("command-status").get_by_role("button", name="Dismiss").click()
    expect(here.find("command-status")).not_to_contain_text("refused")
    here.say("turn lift")
    chip = here.find("command-status .suggested button").first
    expect(chip).to_be_visible()
    chip.click()
    here.until(lambda: console.newest()["source"] == "chip", "what was meant is told")
    cancel = here.button("Cancel command")
    here.told(lambda: here.say("turn left"), "cancelled", then=lambda: cancel.click(timeout=3000))
    offers = here.find(".record").filter(has_text="turn lift").first.locator(".suggested button")
    expect(offers).to_have_text(["turn left", "turn right"])  # the status line has gone on
    here.told(lambda: offers.last.click(), "cancelled", then=lambda: cancel.click(timeout=3000))
    assert console.newest()["words"] == "turn right"


@pytest.mark.parametrize("size", [DESK, PHONE])
def test_one_command_that_was_meant_is_sent_by_enter(visit: Open, console: Running, size: tuple[int, int]) -> None:
    here = visit(size=size)
    here.find("#words").fill("drive 0.02 metre")
    here.page.keyboard.press("Enter")
    here.page.keyboard.press("Enter")  # twice by mistake
    meant = here.find("command-status .suggested button")
    expect(meant).to_have_count(1)
    expect(meant).to_contain_text("continue 0.02 meters")
    expect(meant).to_have_attribute("data-enter", "")
    assert (console.newest()["words"], console.newest()["state"]) == ("drive 0.02 metre", "refused"), "it stood"
    expect(here.find("#words")).to_be_focused()
    here.page.keyboard.press("Enter")
    here.until(lambda: console.newest()["words"] == "continue 0.02 meters", "what was meant is sent")
    assert console.newest()["source"] == "chip"
    here.page.keyboard.press("Escape")
    here.still()


class LateHistory:
    """The newest rows of the history come to the page when a test wants them to."""

    def __init__(self) -> None:
        self.hidden = 0  # newest rows that the page does not have yet
        self.known = False  # the page has had rows
        self._revision = 0

    def lie_between(self, page: Page) -> None:
        """From before the page opens."""

        def link(line: WebSocketRoute) -> None:
            line.connect_to_server().on_message(lambda told: line.send(self._renumbered(told)))

        def rows(route: Route) -> None:
            answer = route.fetch()
            told = answer.json()
            route.fulfill(response=answer, json=told | {"commands": told["commands"][self.hidden :]})
            self.known = True

        page.route_web_socket("**/ws", link)
        page.route("**/api/commands/history*", rows)

    def hide(self, rows: int) -> None:
        """The page asks anew and gets all but these."""
        self.hidden, self._revision = rows, self._revision + 1

    def _renumbered(self, told: str | bytes) -> str | bytes:
        message = json.loads(told) if isinstance(told, str) else {}
        return json.dumps(message | {"history_revision": self._revision}) if "history_revision" in message else told


def test_what_was_meant_stays_offered_when_the_history_tells_of_an_earlier_refusal_late(visit: Open) -> None:
    history = LateHistory()
    here = visit(before=history.lie_between)
    status, suggestions = here.find("command-status"), here.find("command-status .suggested button")
    here.until(lambda: history.known, "the page knows what was before")
    here.say("continue 99 meters")
    expect(status).to_contain_text("continue 99")
    here.say("turn lift")
    expect(suggestions).to_have_text(["turn left", "turn right"])
    history.hide(1)
    expect(here.find(".record").first).to_contain_text("continue 99")
    expect(status).to_contain_text("turn lift")  # the newer of the two, though its row is not there yet
    history.hide(0)
    expect(here.find(".record").first).to_contain_text("turn lift")
    expect(status).to_contain_text("turn lift")
    expect(suggestions).to_have_text(["turn left", "turn right"])


def test_the_status_line_tells_the_newest_fact(visit: Open, console: Running) -> None:
    here = visit()
    status = here.find("command-status")
    here.told(lambda: here.say("turn left"), "done")
    here.page.keyboard.press("Escape")
    expect(status).to_contain_text("Stopped")
    assert "done" not in status.inner_text()
    console.ask("api/halt", {})
    expect(status).to_contain_text("Halted")
    here.find("#words").focus()
    here.say("turn left")
    expect(status).to_contain_text("refused")
    expect(here.find(".banner").filter(has_text="Halted by operator")).to_be_visible()
    expect(here.find(".toast").filter(has_text="halted the robot")).to_have_count(0)  # the banner says it already
    here.button("Reset the halt").click()
    expect(status).to_contain_text("Reset, ready")
    here.hold("s", lambda: "Driving by hand" in status.inner_text(), "the hand is told")
    here.page.keyboard.up("s")
    expect(status).to_contain_text("Ready")


class Doctored:
    """What the console tells the page, with some of it replaced."""

    def __init__(self) -> None:
        self.change: dict[str, object] = {}

    def lie_between(self, page: Page) -> None:
        """From before the page opens."""

        def link(line: WebSocketRoute) -> None:
            line.connect_to_server().on_message(lambda told: line.send(self._changed(told)))

        page.route_web_socket("**/ws", link)

    def _changed(self, told: str | bytes) -> str | bytes:
        message = json.loads(told) if isinstance(told, str) else {}
        return json.dumps(message | self.change) if message.get("kind") == "state" else told


def test_a_notice_passes_once_and_changes_and_ends_where_it_stands(visit: Open) -> None:
    line = Doctored()
    line.change = {"notices": []}
    here = visit(before=line.lie_between)
    toasts, rows = here.find(".toast"), here.find("notice-list .record")
    here.open_tab("Notices")
    for percent in (85, 48, 60):
        line.change = {"notices": [notice("warning", f"Its time runs at {percent} %.")]}
        expect(toasts).to_have_text([f"Its time runs at {percent} %."])
        expect(rows).to_have_count(1)
        expect(rows).to_contain_text(f"{percent} %")
    line.change = {"notices": [notice("warning", 12 * "It is slow. ")]}
    expect(toasts).to_contain_text("It is slow. It is slow.")
    away = here.button("Dismiss").bounding_box()
    assert away is not None and min(away["width"], away["height"]) >= 24
    here.button("Dismiss").click()
    line.change = {"notices": [notice("warning", "Its time runs at 70 %.")]}
    expect(rows).to_contain_text("70 %")
    line.change = {"notices": [notice("info", "It keeps up again.")]}
    expect(rows).to_have_text(re.compile("It keeps up again"))
    assert toasts.count() == 0


def notice(level: str, text: str, number: int = 900) -> dict[str, object]:
    return {"id": number, "stamp_s": 1.0, "level": level, "text": text}


def test_a_notice_gives_way_to_a_newer_one_on_a_phone_and_to_a_sentence_that_says_it(
    visit: Open, console: Running
) -> None:
    line = Doctored()
    line.change = {"notices": []}
    here = visit(size=PHONE, before=line.lie_between)
    toasts = here.find("notice-toasts")
    first, second, third = notice("info", "One.", 900), notice("info", "Two.", 901), notice("warning", "Three.", 902)
    line.change = {"notices": [first]}
    expect(here.find(".toast")).to_have_text(["One."])
    line.change = {"notices": [first, second]}
    expect(toasts.get_by_text("Two.")).to_be_visible()
    expect(toasts.get_by_text("One.")).to_be_hidden()
    line.change = {"notices": [first, second, third]}
    expect(toasts.get_by_text("Three.")).to_be_visible()
    expect(toasts.get_by_text("Two.")).to_be_hidden()
    here.page.set_viewport_size({"width": 1440, "height": 900})
    expect(toasts.get_by_text("One.")).to_be_visible()  # there is room for all
    here.page.set_viewport_size({"width": PHONE[0], "height": PHONE[1]})
    expect(here.find("map-switch")).to_be_visible()
    console.ask("api/halt", {})
    banner = here.find(".banner").filter(has_text="Halted")
    expect(banner).to_be_visible()
    assert here.find("map-switch").evaluate("one => getComputedStyle(one).visibility") == "hidden"
    words = banner.locator(".banner-text").inner_text()
    line.change = {"notices": [first, second, third, notice("info", words, 903)]}
    expect(here.find("notice-list .record").filter(has_text=words)).to_have_count(1)
    expect(here.find(".toast").filter(has_text=words)).to_have_count(0)  # the banner says it
    console.ask("api/halt/reset", {})
    expect(here.find("map-switch")).to_be_visible()


def test_no_figure_is_written_with_a_hyphen_for_its_minus(visit: Open) -> None:
    line = Doctored()
    here = visit(before=line.lie_between)
    pose = {"x_m": -1.5, "y_m": -0.25, "heading_rad": -0.5, "cov": [[1e-4, 0, 0], [0, 1e-4, 0], [0, 0, 1e-4]]}
    line.change = {"pose": pose, "velocity": {"v_m_s": -0.1, "w_rad_s": -0.5}}
    expect(here.find("estimate-line")).to_contain_text("−1.50 m")
    expect(here.find("estimate-line")).to_contain_text("−28.6°")
    expect(here.find("drive-pad")).to_contain_text("−0.10 m/s")
    for name in ("Estimate", "Voices", "SLAM", "Places", "History"):
        here.open_tab(name)
        hyphens = re.findall(r"(?:^|[\s±(])-\d\S*", here.find("body").inner_text())
        assert hyphens == [], name


def test_what_to_say_where_stands_beside_what_is_heard(visit: Open, console: Running) -> None:
    here = visit()
    hint = here.find("hearing-card .hearing-words .note:not([hidden])")
    here.open_tab("Voices")
    here.say("stop moving")  # who drives may let voices give orders
    for name, says in (("Listen", "press Obey"), ("Obey", "Say a command in the room")):
        here.find("hearing-card").get_by_role("button", name=name).click()
        expect(hint).to_contain_text(says)
    here.find("hearing-card").get_by_role("button", name="Listen").click()
    expect(hint).to_contain_text("let the robot listen")


def test_there_is_a_button_for_every_command_that_moves_or_stops_and_numbers_are_asked_for_in_place(
    visit: Open, console: Running
) -> None:
    here = visit()
    known = console.ask("api/commands")["commands"]
    expect(here.find(".chips .chip")).to_have_count(sum(each["name"] != "start" for each in known))
    chip = here.find('.chips [data-command="continue"]')
    here.button("more").click()
    chip.click()
    box = here.find(".chip-form input")
    box.fill("99")
    here.page.keyboard.press("Enter")
    expect(here.find(".form-says")).to_contain_text("from 0.01 to 20")
    box.fill("0.1")
    here.page.keyboard.press("Enter")
    expect(here.find(".record").first).to_contain_text("continue 0.1 meters")
    focused = '.chips [data-command="continue"]:focus, .chip.more:focus'  # by the width of this machine's letters
    expect(here.find(focused)).to_have_count(1)
    assert (console.newest()["source"], console.newest()["numbers"]) == ("chip", {"distance_m": 0.1})
    here.page.keyboard.press("Escape")


def test_come_here_is_in_sight_at_every_width_though_its_note_may_have_no_room(visit: Open) -> None:
    here = visit()
    chip = here.find('.chips [data-command="come_here"]')
    for width, height in ((1440, 900), (1280, 800), (1024, 768), (820, 1180), (390, 844)):
        here.page.set_viewport_size({"width": width, "height": height})
        here.laid_out()
        expect(chip).to_be_visible()


def test_the_first_hints_notice_what_was_done(visit: Open, console: Running) -> None:
    here = visit(hints=True)
    hint = here.find(".coach")
    expect(hint).to_contain_text("Turn the robot")
    here.find("[data-command=turn_left]").click()
    expect(hint).to_contain_text("Hold to drive")
    here.page.keyboard.press("Escape")
    here.still()
    here.hold("s", lambda: "Click the floor" in hint.inner_text(), "the hint notices the driving")
    here.page.keyboard.up("s")
    here.still()
    box = here.find("flat-map").bounding_box()
    assert box
    here.page.mouse.click(box["x"] + 0.42 * box["width"], box["y"] + 0.42 * box["height"])
    expect(here.button("Cancel command")).to_be_visible()
    here.page.keyboard.press("Escape")  # who pressed the floor and stopped knows how
    expect(hint).to_contain_text("Stop, at any time")
    here.button("STOP").click()
    expect(hint).to_contain_text("That is all")
    here.button("Done").click()
    here.page.reload()
    expect(here.find("link-chip")).to_contain_text("Hz", timeout=1000 * PATIENCE)
    here.wait(0.5)
    assert not hint.is_visible()


def test_the_first_hints_go_on_where_they_were_left_and_do_not_cover_a_list(visit: Open) -> None:
    here = visit(size=PHONE, hints=True)
    hint = here.find(".coach")
    expect(hint).to_contain_text("Turn the robot")
    hint.get_by_role("button", name="Skip").click()
    expect(hint).to_contain_text("Hold to drive")
    here.page.reload()
    expect(hint).to_contain_text("Hold to drive", timeout=1000 * PATIENCE)
    expect(hint).to_contain_text("2 of")
    here.button("Details").click()
    expect(hint).to_be_hidden()
    here.button("Map").click()
    expect(hint).to_be_visible()


def test_the_first_hints_do_not_cover_why_a_command_was_refused(visit: Open) -> None:
    here = visit(hints=True)
    hint, status = here.find(".coach"), here.find("command-status")
    expect(hint).to_contain_text("Turn the robot")
    before = status.bounding_box()
    here.say("turn around at the next corner and look for somebody else")
    expect(status).to_contain_text("refused")
    here.wait(0.5)
    box, why = hint.bounding_box(), status.bounding_box()
    assert before and box and why
    assert why["height"] > before["height"]
    assert box["y"] + box["height"] <= why["y"] or why["y"] + why["height"] <= box["y"]


def test_the_first_hints_do_not_cover_a_notice(visit: Open) -> None:
    line = Doctored()
    line.change = {"notices": []}
    here = visit(hints=True, before=line.lie_between)
    hint, toast = here.find(".coach"), here.find(".toast")
    expect(hint).to_contain_text("Turn the robot")
    line.change = {"notices": [notice("warning", "Its time runs at 85 %.")]}
    expect(toast).to_contain_text("85 %")
    here.wait(0.5)
    box, said = hint.bounding_box(), toast.bounding_box()
    assert box and said
    assert box["y"] + box["height"] <= said["y"]


def test_on_a_phone_the_first_hints_wait_while_a_notice_is_read(visit: Open) -> None:
    line = Doctored()
    line.change = {"notices": []}
    here = visit(size=PHONE, hints=True, before=line.lie_between)
    hint, toast = here.find(".coach"), here.find(".toast")
    expect(hint).to_be_visible()
    line.change = {"notices": [notice("warning", "Its time runs at 85 %.")]}
    expect(toast).to_contain_text("85 %")
    expect(hint).to_be_hidden()  # both together cover the robot
    toast.get_by_role("button").first.click()
    expect(hint).to_be_visible()


def test_on_a_phone_the_hint_is_small_the_question_whole_and_no_notice_lies_over_the_map(visit: Open) -> None:
    no_webgl = "HTMLCanvasElement.prototype.getContext = (own => function (kind, ...more) {" + (
        "return kind.startsWith('webgl') ? null : own.call(this, kind, ...more) })"
        "(HTMLCanvasElement.prototype.getContext)"
    )
    here = visit(size=PHONE, hints=True, before=lambda page: page.add_init_script(no_webgl))
    expect(here.find(".coach")).to_contain_text("Turn the robot")
    expect(here.find(".flat-why")).to_be_hidden()
    box, stage = here.find(".coach").bounding_box(), here.find(".over").bounding_box()
    assert box and stage
    assert box["height"] * box["width"] < 0.25 * stage["height"] * stage["width"]
    needs = """() => {
        const box = document.querySelector("#words"), brush = new OffscreenCanvas(1, 1).getContext("2d");
        const style = getComputedStyle(box);
        brush.font = style.font;
        return brush.measureText(box.placeholder).width + parseFloat(style.paddingLeft) <= box.clientWidth; }"""
    assert here.page.evaluate(needs)


def test_a_refusal_says_once_what_may_have_been_meant_and_a_second_slash_is_no_word(visit: Open) -> None:
    here = visit()
    status = here.find("command-status")
    here.say("trun left")
    expect(status.locator(".status-remark")).to_contain_text("Did you mean one of these?")
    expect(status.get_by_role("group", name="Did you mean")).to_have_text("turn left")
    here.page.keyboard.press("Escape")
    here.told(lambda: here.page.keyboard.type("//turn right\n"), "done")
    expect(here.find("history-list .record-words").first).to_have_text("turn right")


NARROW = """() => {
    const boxes = all => [...document.querySelectorAll(all)].map(one => one.getBoundingClientRect());
    const [bar] = boxes(".bar"), badges = boxes("robot-badge > .badge:not([hidden])");
    const around = boxes(".bar > :is(page-menu, link-chip)");
    const apart = (a, b) => a.right <= b.left || b.right <= a.left || a.bottom <= b.top || b.bottom <= a.top;
    const badge = document.querySelector("robot-badge");
    return badges.length === 2 && badge.scrollWidth <= badge.clientWidth && apart(badges[0], badges[1])
        && badges.every(one => one.top >= bar.top && one.bottom <= bar.bottom)
        && badges.every(one => around.every(other => apart(one, other)));
}"""


def test_the_pace_of_a_slow_simulator_is_whole_on_the_narrowest_page(visit: Open, console: Running) -> None:
    line = Doctored()
    line.change = {"robot": console.ask("api/state")["robot"] | {"pace": 0.6}}
    for language, widths in (("en", (320,)), ("de", (390, 320))):
        words = f"localStorage.setItem('beckon.language', '{language}')"
        here = visit(size=(320, 740), before=lambda page: (line.lie_between(page), page.add_init_script(words)))  # noqa: B023
        pace = here.find("robot-badge [data-tone=stale]")
        expect(pace).to_contain_text("0.6", timeout=1000 * PATIENCE)
        for path in ("", "experiments", "recordings", "calibrate"):
            here.go(path)
            for width in widths:
                here.page.set_viewport_size({"width": width, "height": 740})
                here.laid_out()
                assert here.page.evaluate(NARROW), (width, language, path)


@pytest.mark.campaign
def test_the_first_hints_wait_while_someone_else_drives(visit: Open, console: Running) -> None:
    here = visit(hints=True)
    hint = here.find(".coach")
    expect(hint).to_be_visible()
    other = visit()
    other.find("lease-chip button").first.click()
    other.page.get_by_role("button", name=re.compile("^Take")).click()
    expect(here.button("turn left")).to_be_disabled()
    expect(hint).to_be_hidden()
    other.find("lease-chip button").first.click()
    other.page.get_by_role("button", name="Give control back").click()
    expect(hint).to_be_visible()


def test_a_refused_microphone_is_told_in_words(visit: Open) -> None:
    here = visit(before=lambda page: page.add_init_script(f"({REFUSE})()"))
    here.page.get_by_role("button", name="Hold to talk").dispatch_event("pointerdown", {"button": 0, "pointerId": 1})
    expect(here.find(".voice-says")).to_contain_text("refused. Allow it", timeout=2000 * PATIENCE)
