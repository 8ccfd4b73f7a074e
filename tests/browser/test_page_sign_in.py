"""A link for someone else, made and revoked on the page."""

from collections.abc import Callable, Iterator

import pytest
from playwright.sync_api import expect

from tests.browser.visit import PHONE, Visit
from tests.console.live import Live

Open = Callable[..., Visit]


class Door:
    def __init__(self, live: Live) -> None:
        self.live = live
        self.driving = f"http://127.0.0.1:{live.port}/#t={live.admin}"


@pytest.fixture(scope="module")
def console(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Door]:
    with Live(tmp_path_factory.mktemp("door"), pace=0.25) as live:
        yield Door(live)


def test_a_link_is_made_with_its_code_and_revoked_on_a_phone(visit: Open, console: Door) -> None:
    here = visit(size=PHONE)
    here.button("Menu").click()
    here.find("app-menu").get_by_text("Phones and sign-ins").click()
    here.page.get_by_label("A link for").fill("tablet")
    here.button("Make a link").click()
    expect(here.find(".qr")).to_be_visible()
    token = here.page.get_by_label("Link", exact=True).input_value().partition("#t=")[2]
    assert console.live.ask("GET", "/api/me", token=token).json["role"] == "viewer"
    sheet, stop = here.find("sign-in-sheet .sheet").bounding_box(), here.find(".stop").bounding_box()
    assert sheet and stop and sheet["y"] + sheet["height"] <= stop["y"], "nothing lies under STOP"
    revoke = here.button("Revoke tablet")
    revoke.click()
    here.button("Really?").click()
    expect(revoke).to_have_count(0)
    assert console.live.ask("GET", "/api/me", token=token).status == 401
