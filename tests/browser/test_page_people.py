"""Teaching the robot who someone is, on the page: the simulated person shows how it goes."""

import math
from collections.abc import Callable, Iterator

import pytest
from playwright.sync_api import expect

from tests.browser.visit import Visit
from tests.console.live import Live

Open = Callable[..., Visit]
LONG = 60_000  # [ms]


class Near:
    """Where the page of people is, and what the console behind it says."""

    def __init__(self, live: Live) -> None:
        self.live = live
        self.driving = f"http://127.0.0.1:{live.port}/people#t={live.operator}"

    def chosen(self) -> str | None:
        return self.live.ask("GET", "/api/people", token=self.live.viewer).json["chosen"]


@pytest.fixture(scope="module")
def console(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Near]:
    """A console of its own, on a slow machine: the robot stands where it woke, with room ahead, and knows nobody."""
    with Live(tmp_path_factory.mktemp("people"), pace=0.25) as live:
        yield Near(live)


def check_places(here: Visit) -> None:
    """What is asked for stands beside the picture, which fills its frame."""
    stage, take = here.find("people-stage").bounding_box(), here.button("Take the empty room").bounding_box()
    assert stage and take and take["x"] > stage["x"] + stage["width"]
    assert abs(stage["width"] / stage["height"] - 1.25) < 0.03


def test_someone_is_taught_chosen_and_forgotten(visit: Open, console: Near) -> None:
    there = {"what": "person", "id": "Ann", "x_m": 1.0, "y_m": 1.0, "clothes": "red/blue"}
    console.live.ask("POST", "/api/sim/place", there, token=console.live.operator)
    here = visit(size=(1100, 760))
    page = here.page
    here.button("Begin").click()
    expect(page.get_by_label("Who shows themselves")).to_have_value("Ann")
    expect(page.get_by_role("heading", name="First the empty room")).to_be_visible()
    expect(here.button("Take the empty room")).to_be_enabled()
    expect(here.button("Take the empty room")).to_be_in_viewport()
    check_places(here)
    here.button("Show me").click()
    expect(here.find(".people-waits")).not_to_be_empty()
    pictures = here.find(".people-strip li")
    try:
        expect(pictures).to_have_count(4, timeout=LONG)
    except AssertionError:
        pytest.fail(f"{pictures.count()} pictures: {here.find('.people-text').inner_text()}")
    expect(here.find(".people-waits")).to_be_empty()
    expect(page.get_by_role("heading", name="That is enough")).to_be_visible()
    expect(here.find(".people-strip .sketch-outline")).to_have_count(4)
    page.set_viewport_size({"width": 390, "height": 844})
    german = "(one) => (one.textContent = 'Leeren Raum neu aufnehmen')"
    here.button("Retake the empty room").locator("span").evaluate(german)
    ends = "[...document.querySelectorAll('.people-buttons > *')].map((one) => one.getBoundingClientRect().right)"
    assert max(page.evaluate(ends)) < 390, "no button reaches out of a phone's card, in German either"
    loaded = "[...document.querySelectorAll('.people-strip img')].every((one) => one.naturalWidth > 0)"
    here.until(lambda: page.evaluate(loaded), "the pictures are shown")

    here.button("Cancel").click()
    expect(here.button("Press again: pictures taken so far (4) are deleted")).to_be_visible()
    expect(pictures).to_have_count(4)

    expect(page.get_by_label("Who are you?")).to_have_value("Ann")
    (ann,) = console.live.ask("GET", "/api/sim/people", token=console.live.viewer).json["people"]
    assert (ann["id"], ann["x_m"], ann["y_m"]) == ("Ann", 1.0, 1.0), "she is back where she was"
    here.button("That is me").click()
    expect(page.get_by_role("heading", name="Whom does the robot come to?")).to_be_in_viewport()  # that it worked
    page.set_viewport_size({"width": 1100, "height": 760})
    page.get_by_role("radio", name="Only Ann").check(force=True)
    here.until(lambda: console.chosen() is not None, "Ann is chosen")
    expect(page.get_by_role("radio", name="Only Ann")).to_be_checked()
    here.button("Begin").click()
    expect(page.get_by_label("Who shows themselves")).to_have_value("")  # she is known, and nobody else is there
    here.button("Cancel").click()
    here.button("Forget Ann").click()
    here.button("Keep Ann").click()
    expect(page.get_by_role("radio", name="Only Ann")).to_be_checked()
    here.button("Forget Ann").click()
    here.button("Forget").click()
    expect(page.get_by_role("radio", name="Only Ann")).to_have_count(0)
    expect(page.get_by_role("radio", name="Anybody Every caller")).to_be_checked()
    assert console.chosen() is None


def test_a_person_who_is_near_takes_the_same_room_whatever_their_distance(visit: Open, console: Near) -> None:
    there = {"what": "person", "id": "Ann", "x_m": 1.0, "y_m": 1.0, "clothes": "red/blue"}
    console.live.ask("POST", "/api/sim/place", there, token=console.live.operator)
    here = visit(size=(1440, 900))
    here.page.get_by_role("link", name="Drive").click()
    here.page.get_by_role("tab", name="Voices").click()
    chip = here.find(".person-chip")
    expect(chip).to_be_visible()
    width = """(chip, words) => {
        const note = chip.querySelector(".note").cloneNode();
        note.textContent = words;
        chip.querySelector(".note").replaceWith(note);
        return chip.getBoundingClientRect().width;
    }"""
    near, far = (chip.evaluate(width, words) for words in ("0.9 m, 9° left", "1.3 m, 127° right"))
    assert near == far, "else what stands below it moves under the pointer while the robot drives"

    chip.click()  # who is to be followed can be sent on
    here.button("walk on").click()

    def gone_m() -> float:
        (ann,) = console.live.ask("GET", "/api/sim/people", token=console.live.viewer).json["people"]
        return math.dist((ann["x_m"], ann["y_m"]), (1.0, 1.0))

    here.until(lambda: gone_m() > 0.3, "she walks", LONG / 1000)
