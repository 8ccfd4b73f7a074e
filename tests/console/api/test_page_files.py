"""The page's files: packed for who takes it, asked for again, and not sent twice."""

from __future__ import annotations

from starlette.testclient import TestClient

from console.api.page import PageFiles
from console.sentences import static_folder


def test_texts_travel_packed_and_an_unchanged_one_does_not_travel_again() -> None:
    browser = TestClient(PageFiles(directory=static_folder()))
    plain = browser.get("/js/main.js", headers={"accept-encoding": "identity"})
    first = browser.get("/js/main.js")
    assert "content-encoding" not in plain.headers and first.headers["content-encoding"] == "gzip"
    assert first.text == plain.text == (static_folder() / "js/main.js").read_text()
    assert int(first.headers["content-length"]) < 0.5 * int(plain.headers["content-length"])
    for answer in (plain, first):
        assert answer.headers["cache-control"] == "no-cache"
        again = browser.get("/js/main.js", headers={"if-none-match": answer.headers["etag"]})
        assert (again.status_code, again.content) == (304, b"")
    assert "content-encoding" not in browser.get("/img/phone.webp").headers
