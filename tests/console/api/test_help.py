"""Help: the documentation, rendered by the console itself."""

from __future__ import annotations

import re

from tests.console.live import Live


def test_help_leads_to_the_table_of_contents(live: Live) -> None:
    reply = live.ask("GET", "/help")
    assert reply.status == 307 and reply.headers["location"] == "static/docs/index.md"
    page = live.ask("GET", "/static/docs/index.md")
    assert page.status == 200 and page.headers["content-type"].startswith("text/html")
    assert b"<h1>Beckon: documentation</h1>" in page.body and b'href="tutorials/first-drive.md"' in page.body


def test_a_page_has_its_tables_and_its_way_back(live: Live) -> None:
    page = live.ask("GET", "/static/docs/explanation/safety.md").body.decode()
    assert "<table>" in page and "<script" not in page
    assert re.findall(r'href="((?:\.\./)+)static/css/docs.css"', page) == ["../../../"]


def test_nothing_but_the_documentation_is_served(live: Live) -> None:
    for path in ("none.md", "../index.html", "..%2f..%2fpyproject.toml", "reference"):
        assert live.ask("GET", f"/static/docs/{path}").status in (400, 404)
