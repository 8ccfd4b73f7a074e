"""A gamepad in the page: what it drives, and everything that must make the robot stand."""

import re
from collections.abc import Callable, Iterator

import pytest
from playwright.sync_api import Page, expect

from core.gate.limits import Limits
from core.gate.trace import check, read_trace
from tests.browser.running_console import Running
from tests.browser.visit import DESK, PHONE, Visit

Open = Callable[..., Visit]
DEADMAN, STOP, SLOWER, FASTER = 4, 1, 13, 12
FROZEN, STANDS = 0.3, 0.3  # [s]
OTHER_WAYS = [pytest.param(name, marks=pytest.mark.campaign) for name in ("blur", "pagehide")]
XBOX = "Xbox 360 Controller (STANDARD GAMEPAD Vendor: 045e Product: 028e)"

PADS = """(() => {
  const pads = [];
  const make = (id, mapping, count) => ({
    id, mapping, connected: true, streams: true, stamp: performance.now(), axes: [0, 0, 0, 0],
    buttons: Array.from({ length: count }, () => ({ pressed: false, touched: false, value: 0 })),
  });
  const seen = (pad, index) => {
    if (!pad) return null;
    if (pad.streams) pad.stamp = performance.now();
    const { id, mapping, connected, axes, buttons, stamp } = pad;
    const copies = buttons.map((button) => ({ ...button }));
    return { index, id, mapping, connected, timestamp: stamp, axes: [...axes], buttons: copies };
  };
  navigator.getGamepads = () => pads.map(seen);
  window.testPads = {
    plug(index, id, mapping = "standard", count = 17) {
      while (pads.length < index) pads.push(null);
      pads[index] = make(id, mapping, count);
      dispatchEvent(new Event("gamepadconnected"));
    },
    unplug(index) {
      pads[index] = null;
      dispatchEvent(new Event("gamepaddisconnected"));
    },
    button(index, button, pressed) {
      pads[index].buttons[button] = { pressed, touched: pressed, value: Number(pressed) };
    },
    axis(index, axis, value) { pads[index].axes[axis] = value; },
    freeze(index) { pads[index].streams = false; },
  };
})()"""


class PadHand:
    def __init__(
        self, here: Visit, index: int = 0, *, name: str = XBOX, mapping: str = "standard", buttons: int = 17
    ) -> None:
        self.here = here
        self.index = index
        self.plug(name, mapping, buttons)

    def plug(self, name: str = XBOX, mapping: str = "standard", buttons: int = 17) -> None:
        self.do("plug", name, mapping, buttons)

    def do(self, what: str, *numbers: object) -> None:
        self.here.page.evaluate("([what, ...given]) => testPads[what](...given)", [what, self.index, *numbers])

    def press(self, button: int) -> None:
        self.do("button", button, True)

    def release(self, button: int) -> None:
        self.do("button", button, False)

    def stick(self, forward: float = 0.0, left: float = 0.0) -> None:
        self.do("axis", 1, -forward)
        self.do("axis", 0, -left)

    def rest(self) -> None:
        """Let go of everything, for longer than a reading of the page takes."""
        self.release(DEADMAN)
        self.stick()
        self.here.wait(0.1)

    def turn(self, console: Running) -> None:
        """Hold the deadman and push the stick to the left until the robot turns."""
        self.rest()

        def hold() -> None:
            self.press(DEADMAN)
            self.stick(left=1)

        engaged = self.here.find(".stick[data-engaged]")
        self.here.insist(hold, self.rest, lambda: console.turning() > 0.2 and engaged.count(), "the robot turns")


@pytest.fixture(scope="module", autouse=True)
def lawful(console: Running) -> Iterator[None]:
    """Whatever these tests did, the gate's trace must obey its limits."""
    yield
    assert check(read_trace(console.trace), Limits()) == []


@pytest.fixture
def here(visit: Open) -> Visit:
    return visit(before=fake)


def fake(page: Page) -> None:
    page.add_init_script(PADS)


def stands(here: Visit, console: Running, why: str) -> float:
    """Wait until the gate sends zero → how long it took [s], the asking included."""
    return here.until(lambda: abs(console.ask("api/state")["gate"]["w_rad_s"]) < 0.001, f"zero after {why}", 2.0)


def stays(here: Visit, console: Running, why: str) -> None:
    """The robot does not move by itself."""
    here.still()
    before = console.truth()
    here.wait(0.6)
    assert console.truth() == pytest.approx(before, abs=0.01), why


def test_holding_the_deadman_and_pushing_the_stick_drives_and_releasing_it_stops(
    here: Visit, console: Running
) -> None:
    pad = PadHand(here)
    pad.stick(forward=1)
    stays(here, console, "no deadman")
    pad.turn(console)
    expect(here.find(".lease-text")).to_have_text("You drive")
    pad.release(DEADMAN)
    assert stands(here, console, "the release") < STANDS
    stays(here, console, "the stick is still pushed")
    pad.rest()
    start = console.truth()

    def back() -> None:
        pad.press(DEADMAN)
        pad.stick(forward=-0.8)

    here.insist(back, pad.rest, lambda: console.speed() < -0.02, "it drives back")
    pad.rest()
    here.still()
    assert console.truth() != pytest.approx(start, abs=0.002)


def interrupt(here: Visit, name: str) -> None:
    if name == "hidden":
        here.page.evaluate(
            """() => {
                Object.defineProperty(document, "visibilityState", { value: "hidden", configurable: true });
                document.dispatchEvent(new Event("visibilitychange"));
            }"""
        )
    else:
        here.page.evaluate("name => window.dispatchEvent(new Event(name))", name)


@pytest.mark.parametrize("name", ["hidden", *OTHER_WAYS])
def test_whatever_hides_the_page_stops_and_the_held_deadman_stays_dead(
    here: Visit, console: Running, name: str
) -> None:
    pad = PadHand(here)
    pad.turn(console)
    interrupt(here, name)
    assert stands(here, console, name) < STANDS
    pad.stick(left=0.8)
    stays(here, console, name)
    if name == "hidden":
        here.page.evaluate("() => { delete document.visibilityState }")
        stays(here, console, "shown again")
    expect(here.find(".drive-why[data-tone]")).to_have_text(re.compile(r"\S"))
    pad.turn(console)  # a new press
    pad.rest()


def test_a_page_without_the_focus_is_not_driven(here: Visit, console: Running) -> None:
    here.page.evaluate("() => { document.hasFocus = () => false }")
    pad = PadHand(here)
    pad.press(DEADMAN)
    pad.stick(left=1)
    expect(here.find(".drive-why")).to_contain_text("does not have the focus")
    stays(here, console, "no focus")


def test_a_disconnected_gamepad_stops_the_robot_and_the_page_says_so(here: Visit, console: Running) -> None:
    pad = PadHand(here)
    expect(here.find("notice-toasts")).to_contain_text("Xbox 360 Controller: hold LB and push the stick to drive")
    expect(here.find(".drive-why")).to_have_text("Hold LB and push the stick.")
    pad.turn(console)
    pad.do("unplug")
    assert stands(here, console, "the disconnection") < STANDS
    expect(here.find("notice-toasts")).to_contain_text("Xbox 360 Controller was disconnected")
    expect(here.find(".drive-why")).to_contain_text("Hold to drive")
    pad.plug()
    pad.press(DEADMAN)
    pad.stick(left=1)
    stays(here, console, "it came back in the hand")


def test_a_frozen_gamepad_stops_the_robot(here: Visit, console: Running) -> None:
    pad, why = PadHand(here), here.find(".drive-why")
    for _ in range(5):
        pad.turn(console)
        pad.do("freeze")
        assert stands(here, console, "the freeze") < FROZEN + STANDS
        expect(why).to_contain_text(re.compile(r"The gamepad sent nothing new\. Release LB|interrupted|safety gate"))
        if "nothing new" in why.inner_text():  # a page that was short of time had let go, or was stopped, before
            break
        pad.plug()
    expect(why).to_contain_text("The gamepad sent nothing new. Release LB")
    stays(here, console, "frozen")


def test_the_stop_button_stops_what_the_robot_does_and_what_the_gamepad_does(here: Visit, console: Running) -> None:
    pad = PadHand(here)

    def stop() -> None:
        pad.press(STOP)
        here.wait(0.1)
        pad.release(STOP)

    here.told(lambda: here.say("turn left"), "cancelled", then=stop)
    pad.turn(console)
    stop()
    assert stands(here, console, "STOP") < STANDS
    pad.stick(left=0.8)
    stays(here, console, "still held")
    expect(here.find(".drive-why")).to_contain_text("Stopped. Let go")


def test_who_may_not_drive_is_told_why_and_may_stop(visit: Open, console: Running) -> None:
    here = visit(before=fake, watching=True)
    pad = PadHand(here)
    expect(here.find("notice-toasts")).to_contain_text("you are watching, so it cannot drive. B is STOP")
    pad.press(DEADMAN)
    pad.stick(left=1)
    expect(here.find(".drive-why")).to_contain_text("You are watching")
    stays(here, console, "a viewer")
    driver = visit()
    driver.told(lambda: driver.say("turn left"), "cancelled", then=lambda: pad.press(STOP))


@pytest.mark.campaign
def test_of_two_gamepads_the_held_one_drives(here: Visit, console: Running) -> None:
    one, two = PadHand(here, 0), PadHand(here, 1)
    one.stick(left=-1)
    two.turn(console)
    two.rest()
    here.still()


@pytest.mark.campaign
def test_the_speed_buttons_change_the_speed_of_the_page(here: Visit) -> None:
    pad = PadHand(here)
    for button, speed in ((FASTER, "4"), (SLOWER, "3"), (SLOWER, "2")):
        pad.press(button)
        expect(here.find(".preset[aria-pressed=true]")).to_have_text(speed)
        pad.release(button)
        here.wait(0.1)


def open_sheet(here: Visit) -> None:
    here.find("app-menu button").first.click()
    here.find(".menu").get_by_role("button", name=re.compile("^Gamepad")).click()
    expect(here.find("gamepad-sheet")).to_be_visible()


def test_the_sheet_is_live_and_nothing_drives_while_it_is_open(here: Visit, console: Running) -> None:
    open_sheet(here)
    sheet = here.find("gamepad-sheet")
    expect(sheet).to_contain_text("Connect one and press any of its buttons")
    pad = PadHand(here)
    expect(sheet).to_contain_text("Xbox 360 Controller is connected")
    pad.press(DEADMAN)
    pad.stick(forward=1)
    expect(sheet.get_by_role("meter", name="Forward")).to_have_attribute("aria-valuenow", "100")
    expect(sheet.get_by_role("img")).to_have_attribute("aria-label", "Buttons pressed: LB")
    expect(sheet.locator(".pad-row[data-lit]")).to_have_count(2)
    stays(here, console, "the dialog is open")
    here.page.keyboard.press("Escape")
    expect(sheet).to_be_hidden()
    stays(here, console, "closed with the deadman held")
    pad.turn(console)
    pad.rest()


@pytest.mark.campaign
def test_an_unknown_layout_is_learned_by_pressing_and_kept(here: Visit, console: Running) -> None:
    pad = PadHand(here, name="0079-0006-Generic USB Joystick", mapping="", buttons=12)
    expect(here.find("notice-toasts")).to_contain_text("does not know its layout")
    pad.press(DEADMAN)
    pad.stick(left=1)
    stays(here, console, "an unknown layout")
    pad.rest()
    here.button("Set up").click()
    sheet = here.find("gamepad-sheet")
    sheet.get_by_role("button", name="Set up by pressing").focus()
    here.page.keyboard.press("Enter")
    prompt = sheet.locator(".pad-prompt")
    for words, button in (("Hold to drive: Press and release", 6), ("STOP: Press and release", 2)):
        expect(prompt).to_contain_text(words)
        pad.press(button)
        expect(prompt).to_contain_text("Now let it go")
        pad.release(button)
    for words, axis, value in (("fully forward", 3, 1.0), ("fully to the left", 2, -1.0)):
        expect(prompt).to_contain_text(words)
        pad.do("axis", axis, value)
        expect(prompt).to_contain_text("Now let it go")
        pad.do("axis", axis, 0)
    expect(prompt).to_have_text("Saved in this browser.")
    here.page.reload()
    expect(here.find("link-chip")).to_contain_text("Hz")
    pad.plug("0079-0006-Generic USB Joystick", "", 12)
    here.wait(0.2)

    def hold() -> None:
        pad.press(6)
        pad.do("axis", 2, -1)

    def rest() -> None:
        pad.release(6)
        pad.do("axis", 2, 0)
        here.wait(0.1)

    here.insist(hold, rest, lambda: console.turning() > 0.2, "it turns with what was learned")
    rest()
    here.still()


@pytest.mark.campaign
def test_one_input_is_changed_and_stop_cancels_the_learning(here: Visit, console: Running) -> None:
    pad = PadHand(here)
    open_sheet(here)
    sheet = here.find("gamepad-sheet")
    row = sheet.locator(".pad-row").filter(has_text="Hold to drive")
    change = sheet.get_by_role("button", name="Change: Hold to drive")
    change.click()
    here.wait(0.1)
    pad.press(STOP)
    expect(sheet.locator(".pad-prompt")).to_contain_text("STOP was pressed. The mapping was not changed.")
    pad.release(STOP)
    change.click()
    here.wait(0.1)
    pad.press(5)
    expect(sheet.locator(".pad-prompt")).to_contain_text("Now let it go")
    pad.release(5)
    expect(row).to_contain_text("RB")
    expect(sheet.locator(".pad-row").filter(has_text="Slow, while held")).to_contain_text("LB")
    sheet.get_by_role("button", name="Default mapping").click()
    expect(row).to_contain_text("LB")


@pytest.mark.parametrize("size", [pytest.param(DESK, marks=pytest.mark.campaign), PHONE])
def test_the_sheet_fits_and_leaves_stop_free(visit: Open, size: tuple[int, int]) -> None:
    here = visit(before=fake, size=size)
    PadHand(here)
    open_sheet(here)
    expect(here.find("gamepad-sheet .pad-rows")).to_be_visible()
    for part in here.find("gamepad-sheet button:visible, gamepad-sheet input:visible").all():
        part.scroll_into_view_if_needed()
        box = part.bounding_box()
        assert box is not None and box["x"] >= 0 and box["x"] + box["width"] <= size[0]
        assert part.evaluate(
            """part => {
                const { left, top, width, height } = part.getBoundingClientRect();
                return part.contains(document.elementFromPoint(left + width / 2, top + height / 2));
            }"""
        ), part.evaluate("part => part.outerHTML")
    assert here.page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    here.find(".stop").click(trial=True)
    sheet, stop = here.find("gamepad-sheet .sheet").bounding_box(), here.find(".stop").bounding_box()
    assert sheet is not None and stop is not None
    beside = sheet["x"] + sheet["width"] <= stop["x"]
    assert beside or sheet["y"] + sheet["height"] <= stop["y"] or stop["y"] + stop["height"] <= sheet["y"]
