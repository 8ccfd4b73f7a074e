"""Help: the documentation, rendered by the console itself."""

import json
import re

from console.api.page import PAGE_NAMES
from core.sentences import static_folder
from tests.console.live import Live


def test_the_table_of_contents_can_be_read_without_the_console(live: Live) -> None:
    page = live.ask("GET", "/static/docs/index.md")
    assert page.status == 200 and page.headers["content-type"].startswith("text/html")
    assert b"<h1>Beckon: documentation</h1>" in page.body and b'href="tutorials/first-drive.md"' in page.body


def test_every_page_of_the_shell_is_the_same_document_under_its_old_addresses_too(live: Live) -> None:
    document = live.ask("GET", "/").body
    for page in PAGE_NAMES:
        for address in (f"/{page}", f"/{page}.html"):
            assert live.ask("GET", address).body == document, address
    rows = re.findall(r'path: "([a-z]+)"', (static_folder() / "js/shell/pages.js").read_text())
    assert sorted(rows) == sorted(PAGE_NAMES)


def test_a_browser_that_opens_no_page_s_address_gets_one_and_a_program_a_problem(live: Live) -> None:
    for path, token, way in (
        ("/settings", live.viewer, "./#nothing-at=%2Fsettings"),
        ("/a/b/", live.viewer, "../../#nothing-at=%2Fa%2Fb%2F"),
        ("/a/b", None, "../"),  # where one signs in
        ("/docs", live.viewer, "help#docs"),
        ("/static/docs/how-to/record-a-drive.md", live.viewer, "../../../help#how-to/record-a-drive.md"),
    ):
        reply = live.ask("GET", path, token=token, headers={"Accept": "text/html,*/*;q=0.8"})
        assert (reply.status, reply.headers["location"]) == (303, way), path
    for path, token, status in (("/settings", live.viewer, 404), ("/a/b", None, 401)):
        assert live.ask("GET", path, token=token).status == status


def test_a_page_has_its_tables_and_its_way_back(live: Live) -> None:
    page = live.ask("GET", "/static/docs/explanation/safety.md").body.decode()
    assert '<table tabindex="0">' in page and "<script" not in page
    assert 'href="#who-may-reach-what"' not in page, "a short page has no table of contents"
    assert re.findall(r'href="((?:\.\./)+)static/css/docs.css"', page) == ["../../../"]


def test_a_long_page_has_its_chapters_at_its_side_and_all_that_scrolls_can_be_reached_by_keys(live: Live) -> None:
    page = live.ask("GET", "/docs", token=live.viewer).body.decode()
    chapters = re.findall(r'<li><a href="#([\w-]+)">', page)
    assert len(chapters) > 15 and chapters == re.findall(r'<h2 id="([\w-]+)">', page)
    assert "<pre>" not in page and "<table>" not in page and "<th></th>" not in page


def test_nothing_but_the_documentation_is_served(live: Live) -> None:
    for path in ("none.md", "../index.html", "..%2f..%2fpyproject.toml", "reference", "a%00b"):
        assert live.ask("GET", f"/static/docs/{path}").status in (400, 404)


def test_the_http_interface_is_a_page_of_help_with_every_call_and_what_it_takes(live: Live) -> None:
    page = live.ask("GET", "/docs", token=live.viewer).body.decode()
    described = json.loads(live.ask("GET", "/openapi.json", token=live.viewer).body)
    calls = [f"{method.upper()} {path}" for path, each in described["paths"].items() for method in each]
    assert len(calls) > 50 and re.findall(r"<h3><code>(.*?)</code></h3>", page) == sorted(
        calls, key=lambda call: page.index(f"<h3><code>{call}</code></h3>")
    )
    history = page.split("<h3><code>GET /api/commands/history</code></h3>")[1].split("<h3>")[0]
    assert "<td><code>limit</code></td>" in history and "<td>query</td>" in history and "optional" in history
    spoken = page.split("<h3><code>POST /api/sim/say</code></h3>")[1].split("<h3>")[0]
    assert spoken.count("<td>body</td>") >= 3 and "<code>x_m</code>" in spoken
    assert "image/png" in page and "`" not in re.sub("<!--.*?-->", "", page)


def test_pages_of_help_load_nothing_from_other_hosts(live: Live) -> None:
    for path in ("/docs", "/static/docs/index.md"):
        page = live.ask("GET", path, token=live.viewer).body.decode()
        loaded = re.findall(r'<(?:link|img|script)[^>]*(?:href|src)="([^"]*)"', page)
        assert loaded and not [each for each in loaded if "//" in each]
