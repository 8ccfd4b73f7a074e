"""The documentation: its links lead somewhere, its commands are commands, its reference is that of the code."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from console.cli import build_parser
from console.reference import reference_pages

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "static/docs"
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.rglob("*.md"))]
FENCE = re.compile(r"^ *```sh\n(.*?)^ *```", re.M | re.S)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_link_leads_to_a_file(page: Path) -> None:
    links = re.findall(r"\]\(([^)#\s]+)", page.read_text())
    assert [link for link in links if "://" not in link and not (page.parent / link).exists()] == []


def test_every_page_is_reached_from_the_index() -> None:
    reached, waiting = set[Path](), [DOCS / "index.md"]
    while waiting:
        page = waiting.pop()
        if page in reached:
            continue
        reached.add(page)
        links = re.findall(r"\]\(([^)#\s]+\.md)", page.read_text())
        waiting += [(page.parent / link).resolve() for link in links]
    assert set(DOCS.rglob("*.md")) <= reached


def commands() -> list[tuple[str, str]]:
    """Page and command of every `beckon …` line in a fence."""
    found: list[tuple[str, str]] = []
    for page in PAGES:
        for fence in FENCE.findall(page.read_text()):
            lines = fence.replace("\\\n", " ").splitlines()
            found += [(page.name, line.strip()) for line in lines if line.strip().startswith("beckon ")]
    return found


@pytest.mark.parametrize(("page", "line"), commands())
def test_every_command_is_understood_by_the_command_line(page: str, line: str) -> None:
    build_parser().parse_args(shlex.split(line, comments=True)[1:])


@pytest.mark.parametrize(
    "name", ["cli.md", "settings.md", "robot-file.md", "rest.md", "socket.md", "socket.schema.json", "commands.md"]
)
def test_the_reference_is_that_of_the_code(name: str) -> None:
    assert (DOCS / "reference" / name).read_text() == reference_pages()[name], "run: python -m console.reference"


@pytest.mark.parametrize("room", ["core", "console"])
def test_every_room_has_a_row(room: str) -> None:
    text = (ROOT / room / "README.md").read_text()
    rooms = {path.parent.name for path in (ROOT / room).glob("*/__init__.py")}
    named = set(re.findall(r"`(\w+)[`/]", text))
    assert rooms <= named
