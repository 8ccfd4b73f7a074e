"""The page's files: packed for who takes it, asked for again, and not sent twice."""

import gzip
import re
import shutil
from pathlib import Path

import pytest
from starlette.exceptions import HTTPException
from starlette.testclient import TestClient

from console.api.page_files import COMMENT_LINES, PageFiles, packed, version_of
from core.sentences import static_folder


def test_texts_travel_packed_and_an_unchanged_one_does_not_travel_again() -> None:
    browser = TestClient(PageFiles(static_folder()))
    plain = browser.get("/js/main.js", headers={"accept-encoding": "identity"})
    first = browser.get("/js/main.js")
    assert "content-encoding" not in plain.headers and first.headers["content-encoding"] == "gzip"
    assert plain.text == (static_folder() / "js/main.js").read_text()
    assert int(first.headers["content-length"]) < 0.5 * int(plain.headers["content-length"])
    for answer in (plain, first):
        assert answer.headers["cache-control"] == "no-cache"
        again = browser.get("/js/main.js", headers={"if-none-match": answer.headers["etag"]})
        assert (again.status_code, again.content) == (304, b"")
    assert "content-encoding" not in browser.get("/img/phone.webp").headers


def test_comments_stay_here_and_code_keeps_its_lines() -> None:
    for path in sorted(static_folder().rglob("js/**/*.js")):
        text = path.read_text()
        sent = gzip.decompress(packed(str(path), path.stat().st_mtime_ns)).decode()
        pairs = list(zip(text.split("\n"), sent.split("\n"), strict=True))
        left_out = [line.strip() for line, left in pairs if line != left]
        assert all(line.startswith(("//", "/*", "*")) for line in left_out), path
        for found in COMMENT_LINES.finditer(text.encode()):  # none of them stands in a template of several lines
            assert COMMENT_LINES.sub(b"", text.encode()[: found.start()]).count(b"`") % 2 == 0, path


def test_what_the_document_names_is_kept_for_good_until_any_file_changes(tmp_path: Path) -> None:
    folder = tmp_path / "static"
    shutil.copytree(static_folder(), folder, ignore=shutil.ignore_patterns("docs"))
    files = PageFiles(folder)
    browser, named = TestClient(files), re.compile(r'(?:src|href)="static(/[^"#]+)')
    before = set(named.findall(files.document()))
    assert len(before) > 30 and all(path.startswith("/v-") for path in before)
    for path in before:
        answer = browser.get(path)
        assert answer.status_code == 200 and "immutable" in answer.headers["cache-control"]
        again = browser.get(path)
        assert (again.content, again.headers) == (answer.content, answer.headers)
        plain = browser.get(path, headers={"accept-encoding": "identity"})
        assert plain.text.splitlines()[-1:] == answer.text.splitlines()[-1:]
        assert "content-encoding" not in plain.headers
    main = next(path for path in before if path.endswith("/main.js"))
    version = version_of(folder)
    (folder / "js/main.js").write_text("another();")
    assert version_of(folder) != version
    assert before.isdisjoint(named.findall(files.document()))
    old = browser.get(main)
    assert old.text == "another();" and old.headers["cache-control"] == "no-cache"
    for path in (f"/v-{version}/js", f"/v-{version}/../../pyproject.toml", "/v-"):
        with pytest.raises(HTTPException) as missing:
            browser.get(path)
        assert missing.value.status_code == 404
