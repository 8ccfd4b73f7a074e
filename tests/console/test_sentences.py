"""Every sentence that an operator commonly sees has a code, and the catalogue has no sentence that nobody says."""

from __future__ import annotations

import ast
import json
import re
from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest

from console.control.lease import OTHER_DRIVES
from console.http.problems import Problem, problem_of, refused
from console.sentences import KEY, _pattern, code_of, static_folder
from core.errors import Refused

ROOT = Path(__file__).parents[2]
SAID_TO_OPERATORS = (
    "core/commands",
    "core/gate/gate.py",
    "core/gate/status.py",
    "core/navigation",
    "core/pilot/notices.py",
    "core/pilot/pilot.py",
    "core/slam/relocalization/recovery.py",
    "core/speech/understanding/grammar.py",
    "console/connection/service.py",
    "console/control/dispatcher.py",
    "console/control/lease.py",
    "console/control/link_monitor.py",
    "console/control/pending_commands.py",
    "console/control/stop.py",
    "console/speech/browser_microphone.py",
    "console/speech/voice_commands.py",
)
WITHOUT = (
    "An older lease",  # the gate's, for programs that send setpoints themselves
    "One lease has one holder",
    "The setpoint is malformed",
    "Stale: ",
    "Old: its nonce",
    "A speed is not a finite number",
    "It was sent before",
    "The console's heartbeat",
    "Dry run: ",
    "Following the wall",
    "{}",  # put together of others
    "I see nobody.",  # in a dry run
    "I see someone, but not",
    "Stands still and waits",  # summaries of commands
    "Stops moving at once",
    "Turns left",
    "Turns right",
)
COMPOSED = {
    "connect.no_file_start": " Start Beckon with it: beckon run --robot {}",
    "sensor.camera_back": "The camera{} is back.",
    "sensor.camera_back_of": "The camera{} is back.",
    "sensor.laser_back": "The laser{} is back.",
    "sensor.laser_back_of": "The laser{} is back.",
    "sensor.no_picture": "No picture comes from the camera{}.",
    "sensor.no_picture_of": "No picture comes from the camera{}.",
    "sensor.no_scan": "No scan comes from the laser{}.",
    "sensor.no_scan_of": "No scan comes from the laser{}.",
    "way.blocked_back_up": "{} I back up.",
    "way.in_a_wall": "That place is {}; I need {} m around me.{}",
    "way.near_a_wall": "That place is {}; I need {} m around me.{}",
    "words.bounds": "“{}” takes {} from {} to {} {}{}.",
    "words.bounds_spoken": "“{}” takes {} from {} to {} {}{}.",
    "words.longer": "{} I heard “{}”; say it again.",
    "words.more_digits": "{} I heard “{}”; say it again.",
    "words.not_sure": "{} I heard “{}”; say it again.",
    "words.not_whole_number": "{} I heard “{}”; say it again.",
}
"""Codes of sentences of which a part is chosen, and how the program writes them."""


def spoken(node: ast.AST) -> str | None:
    """The text of a string with {} for what is put in; None: no string."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return re.sub(r"\{[^{}]*\}", "{}", node.value)
    if isinstance(node, ast.JoinedStr):
        return "".join(str(part.value) if isinstance(part, ast.Constant) else "{}" for part in node.values)
    return None


def strings(path: Path) -> Iterator[str]:
    """All strings of a module but its docstrings and the summaries of commands."""
    tree = ast.parse(path.read_text())
    left_out: set[int] = set()
    for node in ast.walk(tree):
        alone = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        summary = isinstance(node, ast.AnnAssign) and getattr(node.target, "id", "") == "summary"
        if alone or summary or isinstance(node, ast.JoinedStr):
            left_out |= {id(part) for part in ast.walk(node) if part is not node}
    for node in ast.walk(tree):
        if id(node) not in left_out and (text := spoken(node)) is not None:
            yield text


def modules(*parts: str) -> list[Path]:
    return [
        path
        for part in parts
        for path in ([ROOT / part] if part.endswith(".py") else sorted((ROOT / part).rglob("*.py")))
    ]


@pytest.fixture(scope="module")
def catalogue() -> dict[str, str]:
    texts: dict[str, str] = json.loads((static_folder() / "i18n" / "en.json").read_text())
    return {key: text for key, text in texts.items() if key.startswith(KEY)}


def test_a_value_that_stands_twice_in_a_sentence_is_the_same_twice() -> None:
    sentence = "I see {0} corners, not {1}: this looks like {0}, use it."
    pattern = _pattern("I see {seen} corners, not {entered}: this looks like {seen}, use it.")
    found = pattern.fullmatch(sentence.format("10x10", "9x6"))
    assert found is not None and found.groupdict() == {"seen": "10x10", "entered": "9x6"}
    assert pattern.fullmatch("I see 10x10 corners, not 9x6: this looks like 8x8, use it.") is None


def test_every_sentence_that_operators_commonly_see_has_a_code(catalogue: dict[str, str]) -> None:
    said = {
        text
        for path in modules(*SAID_TO_OPERATORS)
        for text in strings(path)
        if re.fullmatch(r"[A-Z“{].* .* .*[.…]", text, re.DOTALL) and not text.startswith(WITHOUT)
    }
    assert len(said) > 100
    assert [text for text in sorted(said) if code_of(text.replace("{}", "7")).code is None] == []


def test_the_catalogue_holds_only_what_the_program_says(catalogue: dict[str, str]) -> None:
    whole = {text for path in modules("core", "console") for text in strings(path)}
    unsaid: list[str] = []
    for key, text in catalogue.items():
        written = COMPOSED.get(key.removeprefix(KEY), re.sub(r"\{\w+\}", "{}", text))
        if written not in whole:
            unsaid.append(f"{key}: {written}")
    assert unsaid == []


def test_every_code_fills_in_its_values_and_is_found_by_its_sentence(catalogue: dict[str, str]) -> None:
    for key, text in catalogue.items():
        values = {name: f"{10 + number}" for number, name in enumerate(re.findall(r"\{(\w+)\}", text))}
        found = code_of(text.format_map(values))
        assert (found.code, found.values) == (key.removeprefix(KEY), values)


def test_a_refusal_carries_the_code_and_the_values_of_its_sentence() -> None:
    problem = problem_of(Refused(OTHER_DRIVES.format(holder="Ann")))
    assert problem.detail == "Ann drives now. Ask for control, or take over."
    body = json.loads(problem.body())
    assert (body["code"], body["values"], body["status"]) == ("lease.other_drives", {"holder": "Ann"}, 409)
    answer = json.loads(msgspec.json.encode(refused(7, problem)))
    assert (answer["code"], answer["values"], answer["detail"]) == (body["code"], body["values"], problem.detail)


def test_a_sentence_without_a_code_is_told_as_before() -> None:
    assert set(json.loads(Problem(404, "There is none.").body())) == {"type", "title", "status", "detail"}
