"""Push to talk with a person's digit: words so far while the button is held, and what was refused is said back."""

import os
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Page, expect

from core.models import MODEL, find
from core.recording.sound_file import read_sound, write_wav
from core.sensors.microphones import Sound
from core.sentences import Statement, plain
from core.speech.recognition.recognizer import at_16_khz
from tests.browser.running_console import Running
from tests.browser.visit import DESK, FLAT, PHONE, Visit

Open = Callable[..., Visit]
RATE = 16_000
LONG = 90_000  # [ms] on a busy machine
COMMAND, TALK = "speech_human_digits/shared_car_slt_3_george_0.flac", "speech_commands_tts/near_slt_012.flac"
LONGEST = 3.2  # [s] of a clip
EVERY = 14.0  # [s] of sound from one clip's begin to the next one's
LEAD = 8.0  # [s] before the first, in which the browser and the worker make ready

NOTE_THE_TIMES = """() => {
  window.noted = { released: 0, reading: 0 };
  addEventListener("keyup", () => { noted.released = performance.now(); }, true);
  new MutationObserver(() => {
    if (!noted.reading && document.querySelector("command-status").innerText.includes("Reading what you said"))
      noted.reading = performance.now();
  }).observe(document.querySelector("command-status"), { childList: true, characterData: true, subtree: true });
}"""


@pytest.fixture(scope="module")
def chromium_flags(tmp_path_factory: pytest.TempPathFactory, shared_data: Path) -> list[str]:
    """A microphone that hears the command and some talk, one after the other."""
    if find(MODEL) is None:
        why = "The model of human voices is not here: beckon models get whisper-tiny.en."
        pytest.fail(why) if os.environ.get("BECKON_REQUIRE_VOICES") else pytest.skip(why)
    rng = np.random.default_rng(0)
    sound = 2e-4 * rng.normal(size=round((LEAD + 2 * EVERY) * RATE))
    for number in range(2):
        samples = at_16_khz(read_sound(shared_data / (COMMAND if number % 2 == 0 else TALK))).samples[:, 0]
        begin = round((LEAD + number * EVERY) * RATE)
        sound[begin : begin + len(samples)] += 0.5 * samples / np.abs(samples).max()
    file = tmp_path_factory.mktemp("talk") / "talk.wav"
    write_wav(file, Sound(stamp=0.0, rate=RATE, samples=sound[:, None]))
    return [
        *FLAT,
        "--use-fake-device-for-media-stream",
        "--use-fake-ui-for-media-stream",
        f"--use-file-for-fake-audio-capture={file}%noloop",
    ]


def hold_while_it_is_said(here: Visit, opened: float, number: int) -> str:
    """Hold the button around the clip of that number, in a microphone that was opened then [s] → the words shown."""
    begin = opened + LEAD + number * EVERY
    here.wait(max(begin - 0.8 - time.monotonic(), 0.0))
    here.page.keyboard.down("v")
    says, shown = here.find(".status-words"), ""
    while time.monotonic() < begin + LONGEST:
        here.wait(0.1)
        text = says.inner_text() if says.is_visible() else ""
        shown = text if text.startswith("“") else shown
    return shown


def picture(here: Visit, name: str) -> None:
    """Keep a picture where someone wants to look at it."""
    folder = os.environ.get("BECKON_PICTURES")
    if folder:
        here.page.screenshot(path=f"{folder}/{name}.png")


@pytest.mark.real_data
@pytest.mark.campaign
@pytest.mark.parametrize("size", [DESK, PHONE], ids=["desk", "phone"])
def test_words_are_shown_while_they_are_said_and_refused_ones_are_said_back(
    visit: Open, console: Running, size: tuple[int, int]
) -> None:
    here = visit(size=size)
    name = "desk" if size == DESK else "phone"
    here.page.keyboard.down("v")
    expect(here.find("command-status")).to_contain_text("Listening", timeout=LONG)
    opened = time.monotonic()
    here.page.keyboard.up("v")
    shown = hold_while_it_is_said(here, opened, 0)
    picture(here, f"partial_{name}")
    here.page.evaluate(NOTE_THE_TIMES)
    here.page.keyboard.up("v")
    busy = os.getloadavg()[0] > (os.cpu_count() or 1)
    assert busy or shown.lower().startswith("“continue")  # else the words come late
    here.until(lambda: here.page.evaluate("noted.reading") > 0, "it says that it reads", 20)
    noted = here.page.evaluate("noted")
    assert noted["reading"] - noted["released"] < (2000 if busy else 300)
    here.until(lambda: console.newest().get("words") == "continue 3 meters", "words come", 60)
    here.page.keyboard.press("Escape")
    hold_while_it_is_said(here, opened, 1)
    here.page.keyboard.up("v")
    status = here.find("command-status")
    expect(status).to_contain_text("I heard “", timeout=LONG)
    picture(here, f"refused_{name}")
    expect(status.get_by_role("group", name="Did you mean").get_by_role("button").first).to_be_visible()
    here.page.keyboard.press("Escape")


def test_what_a_better_model_gives_is_said_in_the_language_of_the_page(visit: Open) -> None:
    drawn = plain(Statement("people.embedded"))

    def german(page: Page) -> None:
        page.add_init_script("localStorage.setItem('beckon.language', 'de')")
        told = {"active": drawn, "installed": False, "megabytes": 36, "licence": "Apache-2.0"}
        people, words = told | {"gives": "See real people"}, told | {"gives": "Understand people better"}
        page.route("**/api/looking", lambda route: route.fulfill(json=people))
        page.route("**/api/recognizer", lambda route: route.fulfill(json=words))

    here = visit(before=german, at="people")
    expect(here.button("Echte Personen sehen: 36 MB")).to_be_visible()
    expect(here.find("people-known")).not_to_contain_text(drawn)
    here.go("")
    here.button("Mikrofon").click()
    expect(here.button("Menschen besser verstehen: 36 MB")).to_be_visible()


@pytest.mark.parametrize("size", [DESK, pytest.param(PHONE, marks=pytest.mark.campaign)], ids=["desk", "phone"])
def test_the_model_of_human_voices_is_offered_where_it_is_absent(visit: Open, size: tuple[int, int]) -> None:
    absent = {
        "active": "pocketsphinx reads the words: it understands clear voices at a short distance.",
        "installed": False,
        "megabytes": 71,
        "gives": "Understand people better",
        "licence": "MIT",
    }
    here = visit(
        size=size, before=lambda page: page.route("**/api/recognizer", lambda route: route.fulfill(json=absent))
    )
    here.button("Microphone").click()
    expect(here.button("Understand people better: 71 MB")).to_be_visible()
    expect(here.find(".voice-panel")).to_contain_text("pocketsphinx reads the words")
    picture(here, f"offer_{'desk' if size == DESK else 'phone'}")
