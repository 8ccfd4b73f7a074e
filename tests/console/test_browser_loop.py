"""The page of `beckon speech-quality --live --browser`, as its small server gives it."""

import re
import urllib.error
import urllib.request
from collections.abc import Iterator
from urllib.parse import urljoin

import numpy as np
import pytest

from console.cli.browser_loop import BrowserLoop

NEEDED = re.compile(r"""(?:from|import|src=|stylesheet" href=|URL\(|import\()\s*["'`]([\w./-]+\.(?:js|css))["'`]""")


@pytest.fixture
def address() -> Iterator[str]:
    with BrowserLoop(np.zeros(16000), 16000) as loop:
        loop.tell([])  # nothing is waited for at the end
        yield loop.address


def status(address: str) -> int:
    try:
        with urllib.request.urlopen(address) as answer:
            return int(answer.status)
    except urllib.error.HTTPError as refused:
        return refused.code


def test_the_page_gets_every_file_that_it_imports(address: str) -> None:
    open_files, seen = [address], set[str]()
    while open_files:
        file = open_files.pop()
        if file in seen:
            continue
        seen.add(file)
        with urllib.request.urlopen(file) as answer:
            kind, text = answer.headers["Content-Type"], answer.read().decode()
        assert kind.startswith("text/"), file
        open_files += [urljoin(file, name) for name in NEEDED.findall(text)]
    names = {file.rsplit("/", 1)[1] for file in seen}
    assert {"speech-loop.js", "microphone.js", "texts.js", "local-storage.js", "base.css"} <= names
    assert status(f"{address}static/i18n/en.json") == status(f"{address}static/i18n/de.json") == 200


@pytest.mark.parametrize(
    "path",
    ["../pyproject.toml", "static/../../pyproject.toml", "static//etc/hosts", "static", "static/docs/glossary.md"],
)
def test_nothing_but_the_files_of_the_page_is_given(address: str, path: str) -> None:
    assert status(address + path) == 404


def test_who_does_not_know_the_secret_gets_nothing(address: str) -> None:
    assert status(urljoin(address, "/")) == status(urljoin(address, "/guessed/orig.wav")) == 404
    assert status(f"{address}orig.wav") == 200
