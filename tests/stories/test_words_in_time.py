"""No words move the robot late, or after something that made them void: random stories, and the rule taken apart."""

import math
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from console.access.logins import Person
from console.control.command_freshness import ABSENT, CommandFreshness, Spoken
from tests.stories.words_in_time import told_story

QUICK = 100  # stories; tests.benchmarks.late_words tells 100,000
SEARCHED = 600  # stories at most, until one shows that a part of the rule is missing
JUDGE, VOID = CommandFreshness.why_not, CommandFreshness.void


def test_no_story_has_a_motion_by_old_or_void_words(tmp_path: Path) -> None:
    moved: Counter[str] = Counter()
    for number in range(QUICK):
        seen = told_story(number, tmp_path)
        assert seen.wrong == [], f"story {number}"
        moved += Counter(seen.uttered[words].source for _, words in seen.motions)
    assert min(moved[source] for source in ("voice", "ears", "file", "typed")) > 5  # it is no robot that never moves


def without(source: str) -> Callable[[CommandFreshness, Spoken, str, Person], str]:
    """Words of this source are not judged."""
    return lambda self, said, by, who: "" if by == source else JUDGE(self, said, by, who)


def ageless(self: CommandFreshness, said: Spoken, by: str, who: Person) -> str:
    return JUDGE(self, replace(said, taken=said.ended), by, who)


def by_anybody(self: CommandFreshness, said: Spoken, by: str, who: Person) -> str:
    why = JUDGE(self, said, by, who)
    return "" if why == ABSENT else why


def but_stops(self: CommandFreshness, why: str, *, objector: Person | None = None, at: float | None = None) -> None:
    VOID(self, why, objector=objector, at=at if objector is None else -math.inf)


def but_newer_commands(
    self: CommandFreshness, why: str, *, objector: Person | None = None, at: float | None = None
) -> None:
    VOID(self, why, objector=objector, at=at if at is None else -math.inf)


def but_hands_and_drivers(
    self: CommandFreshness, why: str, *, objector: Person | None = None, at: float | None = None
) -> None:
    VOID(self, why, objector=objector, at=at if objector is not None or at is not None else -math.inf)


@pytest.mark.parametrize(
    ("what", "mutant"),
    [
        ("why_not", without("voice")),
        ("why_not", without("ears")),
        ("why_not", without("file")),
        ("why_not", ageless),
        ("why_not", by_anybody),
        ("void", but_stops),
        ("void", but_newer_commands),
        ("void", but_hands_and_drivers),
        ("left", lambda self, who: None),
    ],
    ids=["voice", "ears", "file", "age", "presence", "stops", "newer", "hands", "pages"],
)
def test_the_stories_show_when_a_part_of_the_rule_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, what: str, mutant: Any
) -> None:
    monkeypatch.setattr(CommandFreshness, what, mutant)
    assert any(told_story(number, tmp_path).wrong for number in range(SEARCHED))
