"""The page of thresholds: what is reported on the data it was chosen on is said, and no section is left out."""

import dataclasses
import re
from importlib import import_module
from importlib.util import find_spec
from inspect import signature
from pathlib import Path

import pytest

from core.experiments import EXPERIMENTS
from core.settings import Settings
from tests.benchmarks import array_faults

PAGE = (Path(__file__).parents[1] / "static/docs/reference/thresholds.md").read_text(encoding="utf-8")
PARTS = dict(part.split("\n", 1) for part in PAGE.split("\n## ")[1:])
NAMED = re.compile(r"`([^`]+)`")


def rows(title: str) -> list[list[str]]:
    """The cells of a part's table."""
    lines = [line for line in PARTS[title].splitlines() if line.startswith("| ")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[1:]]


APART = rows("Chosen on one set, reported on another")
TOGETHER = rows("Chosen and reported on the same set")
SETS = {name for row in rows("The sets") for name in NAMED.findall(row[0])}
SOURCE = re.compile(r"`(?:beckon experiment ([\w-]+)|(tests\.benchmarks\.\w+))")
SEEDS = re.compile(r"seeds? (\d+(?:(?:,| and| to) \d+)*)|(?:and|,) (\d+) \(")


def drawn_from(text: str) -> set[tuple[str, int]]:
    """Experiment or benchmark, and seed, of everything that a set's description names so."""
    found = SOURCE.search(text)
    if found is None:
        return set()
    seeds: set[int] = set()
    for first, last in re.findall(r"(\d+)(?: to (\d+))?", " ".join(map("".join, SEEDS.findall(text)))):
        seeds |= set(range(int(first), int(last or first) + 1))
    return {(found[1] or found[2], seed) for seed in seeds}


DRAWN = {name: drawn_from(row[1]) for row in rows("The sets") for name in NAMED.findall(row[0])}


@pytest.mark.parametrize("row", APART, ids=lambda row: row[0])
def test_what_a_threshold_was_chosen_on_is_not_what_its_figures_come_from(row: list[str]) -> None:
    chosen, reported = (set(NAMED.findall(cell)) for cell in row[1:])
    assert chosen and reported and not chosen & reported
    assert chosen | reported <= SETS


@pytest.mark.parametrize("row", APART, ids=lambda row: row[0])
def test_what_a_threshold_was_chosen_on_was_not_drawn_from_a_seed_of_its_figures(row: list[str]) -> None:
    """Two names may be of one thing: a seed of the same experiment or benchmark is the same drives and voices."""
    chosen, reported = (set().union(*(DRAWN[name] for name in NAMED.findall(cell))) for cell in row[1:])
    assert not chosen & reported


def test_what_sets_are_drawn_from_exists_and_is_read_as_it_is_written() -> None:
    assert DRAWN["table-2"] == DRAWN["follow-me-5"] == {("table-2", 5)}
    assert DRAWN["rooms-heard"] == {("table-2", 0), ("table-2", 11)}
    assert DRAWN["audio-visual-20"] == {("audio-visual", seed) for seed in range(20, 24)}
    assert DRAWN["echoes-whole"] == {("tests.benchmarks.called_in_echoes", seed) for seed in (11, 12)}
    sources = {source for drawn in DRAWN.values() for source, _ in drawn}
    assert all(one in EXPERIMENTS or find_spec(one) for one in sources)
    (faults,) = DRAWN["array-faults"]
    assert signature(array_faults.main).parameters["seed"].default == faults[1]


@pytest.mark.parametrize("row", TOGETHER, ids=lambda row: row[0])
def test_what_was_tried_besides_is_not_what_a_threshold_was_chosen_on(row: list[str]) -> None:
    chosen = set(NAMED.findall(row[1]))
    assert chosen and chosen <= SETS


def test_every_section_of_the_settings_is_on_the_page() -> None:
    named = set(re.findall(r"`\[(\w+)\]`", PAGE))
    assert named == {field.name for field in dataclasses.fields(Settings)}


def test_the_thresholds_that_are_named_exist() -> None:
    """`core.a.b:NAME`, and further names behind it in its cell; without a name, the module or the settings of one."""
    found = 0
    for row in (*APART, *TOGETHER):
        where = None
        for one in NAMED.findall(row[0]):
            dotted, _, name = one.partition(":")
            if dotted.startswith("core."):
                where = import_module(dotted)
            if name or (where is not None and one.isupper()):
                assert hasattr(where, name or one), f"{where} has no {name or one}"
                found += 1
    assert found > 30
    assert {"gate", "fresh"} <= {field.name for field in dataclasses.fields(Settings().ekf)}
