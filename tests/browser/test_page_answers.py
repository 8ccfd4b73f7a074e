"""The robot answers aloud in the browser, and the pages about its ears open without a complaint."""

import json
import re
from collections.abc import Callable

import pytest
from playwright.sync_api import Request, WebSocketRoute, expect

from core.speech.synthesis import can_speak
from tests.browser.running_console import Running
from tests.browser.visit import FLAT, PHONE, Visit

Open = Callable[..., Visit]
LONG = 40_000  # [ms]
SOME_VIEWS = re.compile(r"^([2-9]|\d\d) views")
SOME_VIEWS_OF_CAMERA = re.compile(r"Camera, ([2-9]|\d\d) views")
DOUBTED = {
    "kind": "transcript",
    "id": 1,
    "words": "turn left",
    "final": True,
    "accepted": False,
    "heard_as": "",
    "reason": "I am not sure that I heard every word right. I heard “turn left”; say it again.",
    "suggestions": ["turn left"],
    "confidence": 0.61,
    "seconds": 0.8,
    "delay_s": 0.1,
}


@pytest.fixture(scope="module")
def chromium_flags() -> list[str]:
    return [*FLAT, "--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream"]


@pytest.mark.skipif(not can_speak(), reason="nothing here speaks: pip install espeakng-loader")
def test_the_robot_answers_aloud_and_hears_nothing_meanwhile(visit: Open) -> None:
    here = visit()
    said: list[str] = []

    def note(request: Request) -> None:
        if request.url.endswith("/api/voice"):
            said.append(json.loads(request.post_data or "{}")["text"])

    here.page.on("request", note)
    here.say("sing a song")
    expect(here.find("command-status")).to_contain_text("refused")
    assert said == []  # off until it is wanted
    here.page.get_by_role("button", name="Microphone", exact=True).click()
    here.page.get_by_label("Leave it open").check(force=True)
    expect(here.find(".voice-says")).to_contain_text("Open: say a command", timeout=LONG)
    here.button("Answers aloud").click()
    expect(here.find(".voice-says")).to_contain_text("Muted while the robot speaks", timeout=LONG)
    expect(here.find(".voice-says")).to_contain_text("Open: say a command", timeout=LONG)
    here.say("sing a song")
    here.until(lambda: len(said) > 1, "the refusal is said", 20.0)
    assert said[0] == "I answer aloud now." and "no such command" in said[1]
    here.page.get_by_role("button", name="Microphone", exact=True).click()
    here.button("Answers aloud").click()
    expect(here.button("Answers aloud")).to_have_attribute("aria-pressed", "false")


def test_the_pages_about_the_ears_open_on_a_phone(visit: Open, console: Running) -> None:
    here = visit(size=PHONE)
    here.open_tab("Voices")
    expect(here.button("Check the microphones")).to_be_visible()
    here.go("hearing")
    expect(here.button("Measure")).to_be_enabled()
    here.find("quality-form").get_by_label("1 m").uncheck()
    expect(here.find("quality-form [role=status]")).to_contain_text("4 places")
    rows = here.find("quality-result tbody tr")  # of nothing that was measured yet: where it would be
    expect(rows).to_have_count(4)
    expect(rows.first).to_contain_text("2 m")
    here.page.goto(f"{console.url}calibrate#microphones")
    expect(here.find(".claps-advice")).to_contain_text("Stand about 2 m away at 0°")
    expect(here.button("Listen for a clap")).to_be_enabled()
    wide = here.page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
    assert wide <= 0


def test_what_was_measured_is_deleted_by_a_second_press_alone_and_a_demo_that_is_left_keeps_its_views(
    visit: Open, console: Running
) -> None:
    here = visit()
    here.page.goto(f"{console.url}calibrate#microphones")
    here.button("Listen for a clap").wait_for()
    here.page.get_by_role("button", name="Show me").click()
    claps = here.find(".claps-list li")
    here.until(lambda: claps.count() > 0, "one clap was heard", LONG / 1000)
    here.page.get_by_role("button", name="Enough shown").click()
    expect(here.button("Start again")).to_be_enabled()
    here.page.set_viewport_size({"width": 360, "height": 640})
    here.button("Start again").click()
    wide = here.page.evaluate("document.querySelector('main:not([hidden])').scrollWidth - innerWidth")
    assert wide <= 0, "the question has room on a phone"
    here.page.get_by_role("button", name=re.compile(r"Press again: claps heard so far \(\d+\) are deleted")).click()
    expect(claps).to_have_count(0)

    here.page.goto(f"{console.url}calibrate#new=camera")
    here.button("Start").click()
    here.button("Show me").click()
    expect(here.find("views-card h2:visible")).to_have_text(SOME_VIEWS, timeout=LONG)
    left = here.page.url.partition("#s=")[2]
    here.go("")
    here.go("calibrate")
    expect(here.find("views-card h2:visible")).to_have_text(SOME_VIEWS, timeout=LONG)
    here.page.goto(f"{console.url}calibrate#new=camera")
    here.button("Start").click()
    expect(here.find("progress-card:visible")).to_be_visible()
    here.page.goto(f"{console.url}calibrate")
    expect(here.find(f"calibration-home .row-open[href*='#s={left}']")).to_contain_text(SOME_VIEWS_OF_CAMERA)
    for row in console.ask("api/calibration/sessions")["sessions"]:
        console.ask(f"api/calibration/sessions/{row['id']}", method="DELETE")


def test_words_heard_with_a_doubt_stand_in_the_box_and_can_be_pressed(visit: Open, console: Running) -> None:
    rests: list[int] = []

    def doubtful(line: WebSocketRoute) -> None:
        """A console that never comes to an end with the first words, and hears the next with a doubt."""

        def answer(told: str | bytes) -> None:
            kind = json.loads(told)["kind"] if isinstance(told, str) else ""
            if kind == "listen":
                line.send(json.dumps({"kind": "listening", "on": True, "why": ""}))
            elif kind == "rest":
                rests.append(1)
                if len(rests) > 1:
                    line.send(json.dumps(DOUBTED))

        line.on_message(answer)

    here = visit(before=lambda page: page.route_web_socket("**/ws/audio", doubtful))
    lease = here.find(".lease-text")
    here.until(lambda: lease.inner_text() in ("You drive", "Nobody drives"), "control is free", 60.0)
    here.page.keyboard.down("v")
    expect(here.find("command-status")).to_contain_text("Listening", timeout=LONG)
    here.page.keyboard.up("v")
    status = here.find("command-status")
    for told in ("Reading what you said", "slow on this computer; type, or wait"):
        expect(status).to_contain_text(told)
    here.page.keyboard.down("v")
    expect(here.find("command-status")).to_contain_text("Listening", timeout=LONG)
    here.page.keyboard.up("v")
    expect(here.find("#words")).to_have_value("turn left")
    expect(here.find(".transcript").first).to_contain_text("61 % certain")
    suggestions = here.find("command-status").get_by_role("group", name="Did you mean").get_by_role("button")
    expect(suggestions).to_have_text("turn left")
    suggestions.click()
    here.until(lambda: console.newest().get("source") == "chip", "what was pressed is an order")
    here.page.keyboard.press("Escape")
    here.still()
