"""The first minute of a stranger, with the mouse alone: someone in the room calls, and the robot comes."""

import math
import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Locator, expect

from core.models import MODEL, find
from tests.browser.running_console import Running
from tests.browser.visit import DESK, PATIENCE, Visit

Open = Callable[..., Visit]
MINUTE = 60.0  # [s] of the simulator's clock
LONG = 150.0  # [s] of a busy machine's


@pytest.fixture(scope="module")
def voices() -> None:
    """The recognizer of human voices."""
    if find(MODEL) is None:
        why = "The model of human voices is not here: beckon models get whisper-tiny.en."
        pytest.fail(why) if os.environ.get("BECKON_REQUIRE_VOICES") else pytest.skip(why)


@pytest.fixture
def newly_started(voices: None, tmp_path: Path) -> Iterator[Running]:
    """A console as it is started without options: Ann and Bob are there, and the robot can show everything."""
    with Running(tmp_path, people=True) as running:
        yield running


@pytest.mark.campaign
def test_within_the_first_minute_someone_calls_and_the_robot_comes(visit: Open, newly_started: Running) -> None:
    here = visit(
        console=newly_started, before=lambda page: page.add_init_script("localStorage.setItem('beckon.map', 'flat')")
    )
    expect(here.find(".person-chip")).to_have_count(2)
    expect(here.find('[data-command="come_here"] .chip-note')).to_have_text("no voice just now")
    begun = newly_started.ask("api/state")["stamp_s"]
    here.find('[data-command="come_here"]').click()
    expect(here.find("command-status")).to_contain_text("I heard nobody")
    expect(here.find(".record").first.get_by_role("button", name="Let Ann call")).to_be_visible()
    call = here.find("command-status").get_by_role("button", name="Let Ann call")
    for _ in range(4):  # a busy computer may understand too late, and says so; then she calls again
        before = newly_started.newest()["id"]
        (call if call.is_visible() else press_her(here)).click()
        here.until(lambda before=before: newly_started.newest()["id"] > before, "she was heard", LONG)
        if newly_started.newest()["state"] != "refused":
            break
    expect(here.find('.chain-step[data-step="heard"][data-lit]')).to_be_visible(timeout=2000 * PATIENCE)
    here.until(lambda: with_words(newly_started)["state"] != "running", "it came", LONG)
    row = with_words(newly_started)
    assert (row["name"], row["state"], row["source"]) == ("come_here", "done", "ears"), row
    assert newly_started.ask("api/state")["stamp_s"] - begun < MINUTE
    x, y, _ = newly_started.truth()
    people = newly_started.ask("api/sim/people")["people"]
    away = {one["id"]: math.hypot(one["x_m"] - x, one["y_m"] - y) for one in people}
    assert away["Ann"] == pytest.approx(0.5, abs=0.1) and away["Bob"] > 1.0
    expect(here.find('[data-command="come_here"] .chip-note')).to_contain_text("voice")
    expect(here.find("command-chain")).to_be_hidden()


def with_words(console: Running) -> dict[str, Any]:
    """The newest command that was understood: the robot's motors may be taken for speech without words."""
    return next(one for one in console.ask("api/commands/history")["commands"] if one["words"])


def press_her(here: Visit) -> Locator:
    """Ann's sentence, by her name in the card *Hearing*."""
    here.open_tab("Voices")
    if not here.find(".people-bubble").is_visible():
        here.find('.person-chip[data-person="Ann"]').click()
    return here.find('[data-says="come here"]')


SIZES = ((1366, 650), (1030, 640), (844, 390), (390, 844))
SHOWN = {"Teach it a person": "camera-view", "Turn": "command-chips", "Drive": "drive-pad", "Click": ".over"}
"""Steps of the tour, and what each shows."""
COVERED = """([card, shown]) => {
  const one = document.querySelector(card).getBoundingClientRect();
  const part = document.querySelector(shown);
  const other = (part?.getClientRects().length ? part : document.querySelector(".over")).getBoundingClientRect();
  const wide = Math.min(one.right, other.right) - Math.max(one.left, other.left);
  const high = Math.min(one.bottom, other.bottom) - Math.max(one.top, other.top);
  return Math.max(0, wide) * Math.max(0, high);
}"""


def looks_through_windows(here: Visit, step: str) -> list[tuple[int, int]]:
    """Windows in which the card was seen beside what this step shows, until the tour goes on."""
    title, seen = here.find(".tour h2"), list[tuple[int, int]]()
    for width, height in SIZES:
        here.page.set_viewport_size({"width": width, "height": height})
        here.until(
            lambda: (
                title.inner_text() != step
                or all(here.page.evaluate(COVERED, [".tour", free]) == 0 for free in (SHOWN[step], ".stop"))
            ),
            f"{SHOWN[step]} and STOP are free in a window {width} wide",
        )
        if title.inner_text() != step:
            break
        seen.append((width, height))
    return seen


@pytest.mark.campaign
def test_the_tours_card_leaves_free_what_it_shows_in_every_window(visit: Open, newly_started: Running) -> None:
    here = visit(
        console=newly_started, before=lambda page: page.add_init_script("localStorage.setItem('beckon.map', 'flat')")
    )
    title, unseen = here.find(".tour h2"), set(SHOWN)
    for _ in range(3):  # a busy computer may come to look when a step is over already
        here.page.evaluate("dispatchEvent(new CustomEvent('show-tour'))")
        expect(title).to_have_text(next(iter(SHOWN)), timeout=LONG * 1000)
        while (step := title.inner_text()) in SHOWN:
            if looks_through_windows(here, step):
                unseen.discard(step)
        if not unseen:
            break
        here.button("End the tour").click()
        expect(here.find(".tour")).to_be_hidden(timeout=LONG * 1000)
    assert not unseen
    everybody = {one["id"] for one in newly_started.ask("api/sim/people")["people"]}
    assert everybody == {"Ann", "Bob"}, "who showed herself, or stepped aside for her, is back"
    here.button("End the tour").click()
    here.page.set_viewport_size({"width": DESK[0], "height": DESK[1]})
