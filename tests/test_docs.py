"""The documentation: its links lead somewhere, its commands are commands, its reference is that of the code."""

import re
import shlex
import tomllib
from importlib import metadata
from pathlib import Path

import pytest

from console.cli import build_parser
from core.experiments import EXPERIMENTS
from core.models import MODELS
from tests.campaign.rows import ROWS
from tests.reference.figures import MARK, filled, filled_pages, results
from tests.reference.pages import reference_pages

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
    "name",
    [
        "cli.md",
        "settings.md",
        "robot-file.md",
        "rest.md",
        "../../js/net/messages.d.ts",
        "../../js/net/rest.d.ts",
        "socket.md",
        "socket.schema.json",
        "commands.md",
        "checks.md",
        "what-happens-when.md",
    ],
)
def test_the_reference_is_that_of_the_code(name: str) -> None:
    assert (DOCS / "reference" / name).read_text() == reference_pages()[name], "run: python -m tests.reference"


def test_every_marked_figure_is_that_of_a_stored_run_on_a_named_commit() -> None:
    pages = filled_pages()
    assert [str(page) for page, text in pages.items() if page.read_text() != text] == [], "run: -m tests.reference"
    stored = results()
    named = {mark[1] for text in pages.values() for mark in MARK.findall(text)}
    assert named == stored.keys(), "a result that no page shows, or the other way round"
    for name, one in stored.items():
        about = EXPERIMENTS[name].about
        assert re.fullmatch("[0-9a-f]{12}", one["made_by"]["commit"]), name
        assert (one["runs"], one["seed"]) == (about.runs, about.seed), name


def test_a_mark_is_filled_with_the_figures_of_its_result() -> None:
    stored = {"one": {"rows": [{"a": 1.234, "b": 0.5}, {"a": 2.0, "b": 0.25}], "by": {"x": {"a": 3.0}}}}
    page = "before <!--=one {rows[1][a]:.2f} m, {rows[0][b]:.0%}-->stale<!--/--> after"
    assert filled(page, stored) == page.replace("stale", "2.00 m, 50 %") == filled(filled(page, stored), stored)
    table = "<!--=one {where}\n| n | a |\n|---|---|\n| {label} | {{a:.1f}} |\n-->\n<!--/-->"
    assert "| n | a |\n|---|---|\n| x | 3.0 |\n<!--/-->" in filled(table.format(where="by", label="{name}"), stored)
    assert "|---|---|\n| 2.0 | 2.0 |\n<!--/-->" in filled(table.format(where="rows[1:2]", label="{a}"), stored)
    with pytest.raises(LookupError):
        filled("<!--=one {gone}--><!--/-->", stored)


def test_every_package_and_model_stands_among_the_licences() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    lists = [
        project["dependencies"],
        *(of for extra, of in project["optional-dependencies"].items() if extra != "test"),
    ]
    packages = {re.split(r"[^A-Za-z0-9-]", line)[0] for lines in lists for line in lines}
    listed = set(re.findall(r"^\| ([a-z0-9-]+) \|", (DOCS / "reference/licences.md").read_text(), re.M))
    assert packages <= listed and listed - packages == {"package", "model"} & listed
    assert all(f"models get {name}`" in (DOCS / "reference/licences.md").read_text() for name in MODELS)


def licence_words(package: str) -> str:
    """What an installed package says of its licence, as one line; "" where it is not installed or says nothing."""
    try:
        said = metadata.metadata(package)
    except metadata.PackageNotFoundError:
        return ""
    classes = [one for one in said.get_all("Classifier") or [] if one.startswith("License")]
    return " ".join([said.get("License-Expression") or "", (said.get("License") or "")[:100], *classes])


def test_licences_are_those_that_the_installed_packages_declare() -> None:
    page = (DOCS / "reference/licences.md").read_text()
    rows = re.findall(r"^\| ([a-z0-9-]+) \|.*\| ([^|]+) \|$", page, re.M)
    said = {package: words for package, _ in rows if (words := licence_words(package)).strip()}
    assert len(said) > 20
    families = re.compile(r"MIT|BSD|Apache|MPL|EPL|PSF|Python Software")
    stated = {package: families.search(text) for package, text in rows if package in said}
    short = {"PSF": "Python Software"}
    wrong = [
        name for name, one in stated.items() if one is None or short.get(one.group(), one.group()) not in said[name]
    ]
    assert wrong == []


def needed_packages() -> set[str]:
    """Whatever Beckon without its tests brings along here, packages of packages, too."""
    waiting, found = ["beckon-console"], set[str]()
    while waiting:
        name = waiting.pop()
        found.add(name)
        try:
            lines = metadata.requires(name) or []
        except metadata.PackageNotFoundError:
            continue
        own = "extra ==" if name != "beckon-console" else "extra == 'test'"
        lines = [line for line in lines if own not in line.replace('"', "'")]
        named = {re.split(r"[^A-Za-z0-9._-]", line)[0].lower() for line in lines}
        waiting += named - found
    return found


def test_no_package_that_is_loaded_is_under_the_gpl() -> None:
    """The library of eSpeak NG, which espeakng-loader brings, runs in a program of its own."""
    found = needed_packages()
    assert len(found) > 40
    assert [name for name in found if re.search(r"(?<![L])GPL|General Public", licence_words(name))] == []


def test_the_threat_model_names_every_row_and_no_other() -> None:
    page = (DOCS / "explanation/threat-model.md").read_text()
    named = {f"R{number}" for number in re.findall(r"\bR(\d+)\b", page)}
    rows = {row.row for row in ROWS}
    of_machines = {"R13", "R37", "R40", "R41", "R42", "R43", "R44", "R46", "R49", "R50"}  # of no one who attacks
    assert named <= rows
    assert rows - named == of_machines


@pytest.mark.parametrize("room", ["README.md", "CONTRIBUTING.md", "core", "console", "static"])
def test_nothing_tells_to_install_what_an_index_holds_under_the_name_of_the_command(room: str) -> None:
    place = ROOT / room
    files = (
        [place]
        if place.is_file()
        else [one for one in place.rglob("*") if one.suffix in (".py", ".md", ".js", ".json")]
    )
    named = re.compile(r"pip (install|download)[^\n`\")]* '?beckon(\[|'|`|\"|\s|$)")
    assert [str(one.relative_to(ROOT)) for one in files if named.search(one.read_text())] == []


@pytest.mark.parametrize("room", ["core", "console"])
def test_every_room_has_a_row(room: str) -> None:
    text = (ROOT / room / "README.md").read_text()
    rooms = {path.parent.name for path in (ROOT / room).glob("*/__init__.py")}
    named = set(re.findall(r"`(\w+)[`/]", text))
    assert rooms <= named
