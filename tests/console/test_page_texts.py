"""What the console says in English alone, the page says in its language: `static/i18n/<language>.console.json`."""

import ast
import json
import re
from pathlib import Path

from console.control.settings_in_use import common
from console.experiments.runs import entry
from console.people.enrollment import ENOUGH, GESTURES, STEP_OUT
from core.commands import VOCABULARY
from core.experiments import EXPERIMENTS
from core.sentences import catalogue
from core.settings import section_kinds

ROOT = Path(__file__).parent.parent.parent
GERMAN: dict[str, str] = json.loads((ROOT / "static/i18n/de.console.json").read_bytes())
HOLE = re.compile(r"\\\{\w+\\\}")
PUT_TOGETHER = re.compile(r"fill the |A corner is too close to the |.*'s field|.*, worst average")


def said(sentence: str) -> bool:
    """Whether the page has it, word by word or with what stands in it."""
    return sentence in GERMAN or any(re.fullmatch(HOLE.sub(".+", re.escape(one)), sentence) for one in GERMAN)


def test_every_setting_of_the_page_has_a_name_and_a_translation() -> None:
    offered = [(section, one) for section in section_kinds() for one in common(section)]
    assert len(offered) > 30
    assert {f"setting.{section}.{one.name}" for section, one in offered} == {
        key for key in catalogue() if key.startswith("setting.")
    }
    texts = {text for _, one in offered for text in (one.meta.meaning, one.watch)}
    assert {text for text in texts if not said(text)} == set()


def test_the_contents_of_help_have_a_translation() -> None:
    titles = re.findall(r"^## (.+)$|\[([^]]+)\]\(", (ROOT / "static/docs/index.md").read_text(), re.MULTILINE)
    assert len(titles) > 50
    assert {one or other for one, other in titles if not said(one or other)} == {"REST"}


def test_every_experiment_every_command_and_the_advice_to_people_have_a_translation() -> None:
    entries = [entry(name) for name in EXPERIMENTS]
    texts = {text for one in entries for text in (one.title, one.reproduces, one.counts) if text}
    texts |= {command.summary for command in VOCABULARY} | {
        STEP_OUT,
        ENOUGH,
        *(gesture.words for gesture in GESTURES),
    }
    assert len(texts) > 30
    assert {text for text in texts if not said(text)} == set()


def test_a_translation_whose_english_is_gone_does_not_stay() -> None:
    """Holes are left out: their sentences are put together."""
    files = [path for room in ("core", "console") for path in (ROOT / room).rglob("*.py")]
    articles = [path.read_text() for path in (ROOT / "static/docs").rglob("*.md")]
    there = " ".join("\n".join(articles).split()) + "\n".join(
        " ".join(node.value.split())
        for path in files
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    )
    kept = {text for text in GERMAN if "{" not in text and not PUT_TOGETHER.match(text)}
    assert len(kept) > 100
    assert [text for text in kept if text not in there] == []


def test_every_word_of_a_report_is_used() -> None:
    source = (ROOT / "console/api/reports.py").read_text()
    names = {key.removeprefix("report.") for key in catalogue() if key.startswith("report.")}
    put_together = {"calibration_camera", "calibration_laser"}
    assert len(names) > 20
    assert {name for name in names if not re.search(rf"\b{name}\b", source)} == put_together
