"""One shell: pages change without loading, STOP and link stay, map and camera are docked; settings, experiments."""

import re
from collections.abc import Callable

import pytest
from playwright.sync_api import Route, expect

from tests.browser.running_console import Running
from tests.browser.visit import DESK, PATIENCE, PHONE, Profiles, Visit
from tests.machine import slowness

Open = Callable[..., Visit]
PAGES = ("Calibrate", "Hearing", "People", "Maps", "Recordings", "Experiments", "Connect", "Help")
DOCKED = ("Hearing", "People", "Maps")
DOCK = 220  # [px] of the map and of the camera, at least


def open_page(here: Visit, name: str) -> None:
    """By the rail, or by the button that stands for it."""
    menu = here.page.get_by_role("button", name=re.compile("^Pages"))
    if menu.is_visible():
        menu.click()
    here.page.get_by_role("navigation", name="Pages").get_by_role("link", name=name, exact=True).click()


RIGHT_EDGES = """() => ["record-button", "lease-chip", "theme-toggle", "app-menu"].map(
    name => Math.round(document.querySelector(`.bar > ${name}`).getBoundingClientRect().right))"""
OTHER_WORDS = """() => {
    document.querySelector(".bar .badge[data-tone]").hidden = false;
    document.querySelector(".bar .link-text").textContent = "1234 ms · 20 Hz";
    document.querySelector(".bar .lease-text").textContent = "You drive";
}"""


def test_a_wide_calibrate_page_has_its_wizards_in_rows_beside_what_the_camera_sees(visit: Open) -> None:
    here = visit(size=DESK, at="calibrate")
    picture = here.find(".home-picture")
    expect(picture).to_be_visible()
    beside = picture.bounding_box()
    cards = [box for one in here.find(".wizard-card").all() if (box := one.bounding_box())]
    assert beside and len(cards) == 3
    assert len({box["x"] for box in cards}) == 1 and cards[0]["x"] + cards[0]["width"] < beside["x"]
    assert cards[-1]["y"] + cards[-1]["height"] <= DESK[1], "none is below the fold"
    here.page.set_viewport_size({"width": 820, "height": 1180})
    expect(picture).to_be_hidden()


def test_no_button_of_the_bar_moves_with_its_words(visit: Open) -> None:
    here = visit()
    here.fresh()
    before, after = here.page.evaluate(f"() => [({RIGHT_EDGES})(), ({OTHER_WORDS})(), ({RIGHT_EDGES})()]")[::2]
    assert len(before) == 4 and before == after


def test_each_drawing_of_the_bar_has_its_word_on_a_phone(visit: Open) -> None:
    here = visit(size=PHONE)
    buttons = here.page.locator(".bar > * > button:visible")
    words = [text.strip() for text in buttons.all_inner_texts()]
    assert words == ["Drive", "Link", "Record", "Control", "Menu"]
    here.find("app-menu > button").click()
    here.page.get_by_role("button", name=re.compile("^Theme")).click()
    expect(here.page.locator("html")).to_have_attribute("data-theme", "dark")


def test_a_picture_of_the_turning_robot_costs_the_page_less_than_a_twentieth_of_a_second(visit: Open) -> None:
    here = visit()
    here.page.emulate_media(reduced_motion="no-preference")
    here.button("Flat").click()
    costs = here.page.context.new_cdp_session(here.page)
    costs.send("Performance.enable", {"timeDomain": "threadTicks"})  # processor time: what else runs does not count

    def spent() -> float:
        rows = costs.send("Performance.getMetrics")["metrics"]
        return next(one["value"] for one in rows if one["name"] == "TaskDuration")

    here.fresh()
    here.say("turn left")
    here.until(lambda: abs(here.console.turning()) > 0.1, "it turns")
    before = spent()
    pictures = here.page.evaluate("""() => new Promise(done => {
        let count = 0, end = performance.now() + 2000;
        const next = now => ++count && now < end ? requestAnimationFrame(next) : done(count);
        requestAnimationFrame(next);
    })""")
    each = (spent() - before) / pictures
    here.button("STOP").click()
    slow = slowness()
    assert each < 0.05 * slow, f"{each:.3f} s for each of {pictures}, {slow:.1f} times as slow as usual"


def test_a_press_in_the_rail_shows_at_once_while_its_page_comes(visit: Open) -> None:
    here = visit()
    held_back: list[Route] = []
    here.page.route("**/connect/main.js", lambda route: held_back.append(route))
    open_page(here, "Connect")
    link = here.page.get_by_role("link", name="Connect", exact=True)
    expect(link).to_have_attribute("data-opening", "")
    assert link.get_attribute("aria-current") is None
    here.until(lambda: held_back, "its module is asked for")
    held_back[0].continue_()
    expect(link).to_have_attribute("aria-current", "page")
    assert link.get_attribute("data-opening") is None


@pytest.mark.parametrize("size", [DESK, PHONE])
def test_pages_change_without_loading_and_stop_link_and_operator_stay(visit: Open, size: tuple[int, int]) -> None:
    here = visit(size=size)
    here.page.evaluate("window.sameDocument = true")
    for name in PAGES if size == DESK else ("People", "Connect", "Help"):
        open_page(here, name)
        heading = here.page.get_by_role("heading", level=1, name=name, exact=True)
        expect(heading).to_be_focused()
        expect(here.page).to_have_title(f"{name} · Beckon")
        for stays in (".stop", "link-chip button", "lease-chip > button"):
            expect(here.find(stays)).to_be_visible()
        docked = name in DOCKED
        for part in ("flat-map, scene-view:visible", ".picture"):
            seen = here.find(part).first
            (expect(seen).to_be_visible if docked else expect(seen).to_be_hidden)()
        if docked and size == DESK:
            for part in (".stage", "camera-view"):
                box = here.find(part).bounding_box()
                assert box and box["width"] >= DOCK and box["height"] >= 150, (name, part, box)
        assert here.page.evaluate("document.documentElement.scrollWidth <= innerWidth"), name
    here.page.go_back()
    expect(here.page.get_by_role("heading", level=1, name="Connect", exact=True)).to_be_visible()
    open_page(here, "Drive")
    expect(here.find("command-line")).to_be_visible()
    assert here.page.evaluate("window.sameDocument"), "the document was loaded again"


def test_beside_a_page_keys_stop_but_do_not_drive(visit: Open, console: Running) -> None:
    here = visit()
    open_page(here, "Help")
    expect(here.find(".docs h2").first).to_be_visible()
    tutorial = here.find(".help-card").first.locator("li a").first
    expect(tutorial).to_contain_text("First drive")
    expect(tutorial.locator(".note")).to_have_text("five minutes with the simulated robot")
    here.page.keyboard.down("w")
    here.wait(0.5)
    here.page.keyboard.up("w")
    assert abs(console.speed()) < 0.005
    here.page.get_by_role("link", name="First drive").click()
    expect(here.page.get_by_role("heading", level=2, name="First drive")).to_be_visible()
    assert here.page.url.endswith("/help#tutorials/first-drive.md")
    console.ask("api/commands", {"text": "turn left"})
    expect(here.find('command-status[data-state="running"]')).to_be_visible()
    here.page.keyboard.press("Escape")
    here.still()
    here.until(lambda: console.newest()["state"] == "cancelled", "it was stopped")
    console.ask("api/lease", {"do": "release"})


def test_until_its_programs_run_a_phones_page_says_that_it_loads(profiles: Profiles, console: Running) -> None:
    page = profiles.take(PHONE, "dark").new_page()
    page.route("**/js/main.js", lambda _: None)  # no answer
    page.goto(console.driving, wait_until="commit")
    expect(page.locator("command-status")).to_be_visible()
    says = "getComputedStyle(document.querySelector('command-status'), '::before').content"
    assert page.evaluate(says) == '"Loading…"'
    page.unroute_all(behavior="ignoreErrors")
    profiles.leave(page, PHONE, "dark")


def test_help_has_german_contents_and_says_that_an_article_is_in_english(visit: Open) -> None:
    here = visit(at="help", before=lambda page: page.add_init_script("localStorage.setItem('beckon.language', 'de')"))
    expect(here.find(".help-lead")).to_have_text("Die Artikel sind auf Englisch.")
    expect(here.find(".help-card h2").first).to_have_text("Zum Kennenlernen")
    here.page.get_by_role("link", name="Erste Fahrt").click()
    expect(here.find(".help-lead")).to_have_text("Erste Fahrt: dieser Artikel ist auf Englisch.")
    article = here.find("article.docs")
    expect(article.get_by_role("heading", name="First drive")).to_be_visible()
    expect(article).to_have_attribute("lang", "en")
    beside = here.page.get_by_role("navigation", name="Inhalt").get_by_role("link", name="Erste Fahrt")
    expect(beside).to_be_hidden()
    here.page.set_viewport_size({"width": 1920, "height": 1080})
    expect(beside).to_have_attribute("aria-current", "page")
    expect(beside).to_be_visible()


def test_a_german_page_says_an_error_in_german_and_fetches_the_words_for_it_first_then(visit: Open) -> None:
    here = visit(
        at="connect", before=lambda page: page.add_init_script("localStorage.setItem('beckon.language', 'de')")
    )
    fetched = "performance.getEntriesByType('resource').filter(({ name }) => name.includes('de.errors')).length"
    url = here.page.get_by_label("URL eines Roboters")
    expect(url).to_be_enabled()
    assert here.page.evaluate(fetched) == 0
    url.fill("foxglove://127.0.0.1:9")
    here.button("Nachsehen").click()
    refused = "Keine foxglove bridge an 127.0.0.1:9: Verbindung abgewiesen. Starten Sie sie auf dem Roboter:"
    expect(here.find(".connect-status")).to_contain_text(refused)
    assert here.page.evaluate(fetched) == 1
    here.complaints[:] = [each for each in here.complaints if "503" not in each]  # the browser notes the refusal


def test_a_setting_is_changed_refused_and_taken_back(visit: Open, console: Running) -> None:
    here = visit()
    here.button("Settings").click()
    speed = here.find("#setting-voice-speed")
    expect(speed).to_have_value("150")
    speed.fill("140")
    speed.press("Tab")
    says = here.find("#setting-voice-speed-says")
    expect(says).to_have_text("Rate of speaking: 140 words/min now.")
    fast = here.page.get_by_label(re.compile("^Highest speed"))
    fast.fill("9")
    fast.press("Tab")
    expect(here.find("#setting-limits-max_speed-says")).to_have_text(re.compile(r"must lie between 0.01 and 1 m/s"))
    fast.fill("")
    fast.press_sequentially("0,25")  # a comma is dropped by a browser that knows the point alone: 25
    expect(fast).to_have_value("0.25")
    fast.press("Tab")
    expect(here.find(".settings-restart")).to_contain_text("next start")
    for name in ("voice/speed", "limits/max_speed"):
        here.find(f"#setting-{name.replace('/', '-')}").locator("xpath=../../button").click()
    expect(here.find(".settings-restart")).to_be_hidden()
    assert not any(one["value"] != one["default"] for one in console.ask("api/settings")["settings"])
    here.page.keyboard.press("Escape")


def test_on_the_narrowest_page_no_name_of_an_experiment_meets_its_button(visit: Open) -> None:
    here = visit(size=(320, 740), at="experiments")
    expect(here.find(".experiments .button").first).to_be_visible(timeout=1000 * PATIENCE)
    gaps = here.page.evaluate("""() => [...document.querySelectorAll(".experiments tbody tr")].flatMap(row => {
        const [name, run] = [row.querySelector("th"), row.querySelector(".button")], words = new Range();
        if (!name || !run) return [];
        words.selectNodeContents(name);
        return [run.getBoundingClientRect().left - words.getBoundingClientRect().right];
    })""")
    assert gaps and min(gaps) >= 8, gaps


def test_a_map_whose_walls_are_on_their_way_says_so(visit: Open) -> None:
    held: list[Route] = []
    here = visit(size=PHONE, before=lambda page: page.route("**/api/map/outline", lambda route: held.append(route)))
    if not here.find("flat-map").is_visible():
        here.button("Flat").click()
    awaits = here.find("flat-map").get_by_text("Reading the map…")
    expect(awaits).to_be_visible()
    here.until(lambda: bool(held), "the walls are asked for")
    expect(awaits).to_be_visible()
    here.page.unroute("**/api/map/outline")  # lets those go on that were held
    expect(awaits).to_be_hidden()


@pytest.mark.parametrize("size", [(1920, 1080), PHONE])
def test_what_the_chapter_has_stands_beside_what_was_found_here(visit: Open, size: tuple[int, int]) -> None:
    """One figure and its run, as the console would say it; on a wide page also before anything was run."""

    def with_a_run(route: Route) -> None:
        answer = route.fetch()
        told = answer.json()
        figure = {"name": "EKF-SLAM, worst average error", "unit": "m", "chapter": 0.08, "ours": 0.039}
        run = {"id": "a", "experiment": "dead-reckoning-vs-slam", "title": "Figure 16", "who": "Ada", "at_s": 1e9}
        run |= {"runs": 5, "seed": 0, "state": "done", "doing": "", "reason": "", "progress": 1.0, "took_s": 1.0}
        route.fulfill(response=answer, json=told | {"runs": [run | {"compared": [figure], "text": "", "files": []}]})

    here = visit(size=size, at="experiments")
    table = here.page.get_by_role("region", name="The chapter's figures")
    expect(table).to_contain_text("EKF-SLAM, worst average error", timeout=1000 * PATIENCE)
    assert table.locator("tr").count() > 10
    if size != PHONE:
        box = table.bounding_box()
        assert box and box["x"] > size[0] / 2 and box["y"] < size[1] / 2, "the right half is not empty"
    here.page.route("**/api/experiments", with_a_run)
    here.page.reload()
    row = table.locator("tr").filter(has_text="EKF-SLAM, worst average error")
    expect(row.locator("td")).to_have_text(["0.080 m", "0.039 m"])
    if size != PHONE:
        box = table.bounding_box()
        assert box and box["x"] < size[0] / 4, "below the list, beside a long result"
    cells = here.find('[data-experiment="dead-reckoning-vs-slam"] td')
    tops = [round(one["y"]) for n in (1, 2) if (one := cells.nth(n).bounding_box())]
    assert len(tops) == 2 and tops[0] == tops[1], "beside each other in the list, too"
    columns = [one.bounding_box() for one in cells.all()]
    here.find("[data-experiment] summary").first.click()
    moved = [one.bounding_box() for one in cells.all()]
    assert [one and one["x"] for one in moved] == [one and one["x"] for one in columns], "columns stay where they are"


def test_experiments_are_listed_and_one_is_cancelled(visit: Open, console: Running) -> None:
    here = visit(size=(820, 700), at="experiments")
    card = here.find('[data-experiment="dead-reckoning-vs-slam"]')
    expect(card).to_contain_text("Figure 16", timeout=2000 * PATIENCE)
    card.get_by_text("Details").click()
    card.get_by_label("drives").fill("9000")
    card.get_by_role("button", name=re.compile("^Run")).click()
    expect(here.find(".run-going").get_by_role("progressbar")).to_be_in_viewport()  # it is below the list
    bar, card_of_it = (here.find(one).bounding_box() for one in (".run-going .meter", ".run-going"))
    assert bar and card_of_it and card_of_it["y"] <= bar["y"] <= card_of_it["y"] + card_of_it["height"]
    expect(card.get_by_role("button", name=re.compile("^Run"))).to_be_disabled()
    here.button("Cancel").click()
    expect(here.find("experiment-runs .rows")).to_contain_text("9000 drives, seed 0")
    here.until(lambda: console.ask("api/experiments")["runs"][0]["state"] == "cancelled", "it was cancelled")
    here.page.get_by_role("button", name=re.compile("^Delete: Figure 16")).first.click()
    expect(here.find("experiment-runs .rows li")).to_have_count(0)


def test_until_the_experiments_are_read_their_table_stands_there_without_words(visit: Open) -> None:
    held: list[Route] = []
    here = visit(before=lambda page: page.route("**/api/experiments", lambda route: held.append(route)))
    open_page(here, "Experiments")
    rows, status = here.find(".experiment-skeleton"), here.find("experiment-list [role=status]")
    expect(rows).to_have_count(4)
    expect(rows.first).to_be_visible()
    assert rows.first.get_attribute("aria-hidden") == "true"
    expect(status).to_have_text("Reading what experiments there are…")
    here.until(lambda: bool(held), "they are asked for")
    here.page.unroute("**/api/experiments")  # lets those go on that were held
    expect(here.find("[data-experiment]").first).to_be_visible()
    expect(rows).to_have_count(0)
    expect(status).to_have_text("")
