"""The fleet's page in a browser: robots and their order, STOP ALL and Halt all, one map, and a map taken over."""

import re
from collections.abc import Iterator

import pytest
from playwright.sync_api import ConsoleMessage, Page, expect

from tests.browser.visit import DESK, HARMLESS, Profiles
from tests.console.live_fleet import LiveFleet
from tests.core.robots.links import until


@pytest.fixture(scope="module")
def page(profiles: Profiles, fleet: LiveFleet) -> Iterator[Page]:
    """The page of one who is signed in; afterwards it may have complained of nothing."""
    page, complaints = profiles.take(DESK, "dark").new_page(), list[str]()

    def note(message: ConsoleMessage) -> None:
        if message.type in ("error", "warning") and not any(part in message.text for part in HARMLESS):
            complaints.append(message.text)

    page.on("console", note)
    page.on("pageerror", lambda error: complaints.append(str(error)))
    fleet.reset()  # pages that were looked at before have halted it
    fleet.share_a_map("r1", "r2")
    page.goto(fleet.driving)
    expect(page.locator(".fleet-card")).to_have_count(4)
    yield page
    profiles.leave(page, DESK, "dark")
    assert complaints == []


def names(page: Page) -> list[str]:
    return page.locator(".fleet-card:visible .fleet-name").all_inner_texts()


def test_stop_all_stops_every_robot_and_the_page_names_who_did_not_answer(page: Page, fleet: LiveFleet) -> None:
    for robot in fleet.robots.values():
        fleet.on_loop(robot.robot.drive)
    expect(page.locator('.fleet-card[data-link="live"] .fleet-picture:visible')).to_have_count(3)
    loud = page.locator(".fleet-card-stop:not([data-still])")
    expect(loud).to_have_count(1)  # the three that report that they stand have a quieter one
    expect(page.locator(".stop[data-still]")).to_have_count(0)  # nobody knows what the fourth does
    page.locator(".stop").click()
    answers = page.locator("fleet-answers")
    expect(answers).to_contain_text("3 of 4 robots stand")
    expect(answers.locator("li")).to_have_count(3)
    expect(answers.locator("[role=alert]")).to_contain_text("No answer from r4 (gone)")
    assert all(robot.robot.status().v == 0.0 for robot in fleet.robots.values())
    page.get_by_role("button", name="Halt all").click()
    expect(page.locator("fleet-banner")).to_contain_text("All robots are halted, by operator")
    until(lambda: all(robot.robot.status().state == "halted" for robot in fleet.robots.values()))
    expect(page.locator(".fleet-card[data-group=help]")).to_have_count(3)
    page.get_by_role("button", name="Reset", exact=True).click()
    expect(page.locator(".fleet-halted")).to_be_hidden()
    fleet.on_loop(fleet.robots["r3"].robot.reset)
    page.get_by_role("button", name=re.compile("need help")).click()
    until(lambda: sorted(names(page)) == ["r1", "r2"])
    page.get_by_role("button", name=re.compile("need help")).click()
    assert names(page)[-2:] == ["r3", "r4"], "who needs help stands first, who never came last"
    page.get_by_role("button", name="Stop r3").click()
    until(lambda: ("/api/stop", b"") in fleet.consoles.posted)


def test_robots_of_one_map_are_shown_on_it_and_a_saved_map_is_taken_to_another(page: Page, fleet: LiveFleet) -> None:
    expect(page.locator(".fleet-map h2")).to_have_text("On one map: lab")
    expect(page.locator(".fleet-spot")).to_have_text(["r1", "r2"])
    assert page.locator(".fleet-spot").first.get_attribute("href") == "/robots/r1/"
    one, other = (page.locator(".fleet-spot").nth(number).bounding_box() or {} for number in (0, 1))
    assert abs(one["x"] - other["x"]) >= one["width"] or abs(one["y"] - other["y"]) >= one["height"], "names apart"
    page.get_by_role("button", name="Share places, zones and routes").click()
    expect(page.locator(".fleet-map [role=status]")).to_have_text("Added at robots that lacked them: 0.")
    page.locator(".fleet-take summary").click()
    page.get_by_label("To", exact=True).select_option("r3")
    expect(page.get_by_label("Map", exact=True)).to_have_value("lab")
    page.get_by_role("button", name="Take", exact=True).click()
    expect(page.locator(".fleet-take [role=status]")).to_contain_text("r3 has the map “lab” now")
    assert ("/api/maps/import?name=lab", b"PK") in fleet.consoles.posted
    assert page.get_by_role("link", name="Load it at r3").get_attribute("href") == f"{fleet.url}robots/r3/maps"
    page.set_viewport_size({"width": 1920, "height": 1080})
    plan = page.locator(".fleet-map").bounding_box()
    ends = [box["x"] + box["width"] for one in page.locator(".fleet-card").all() if (box := one.bounding_box())]
    assert plan and len(ends) == 4 and 0 <= plan["x"] - max(ends) < 24, (
        "four robots leave no empty column beside the map"
    )
    page.set_viewport_size({"width": DESK[0], "height": DESK[1]})
