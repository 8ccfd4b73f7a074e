"""Every command refuses in one way: a sentence on standard error and, with `--json`, one object with its code."""

import argparse
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from console.__main__ import main
from console.cli import build_parser, understand
from console.cli.answer import GrowingJson
from core.errors import Unavailable


def leaves(parser: argparse.ArgumentParser) -> Iterator[str]:
    """The commands that have none below, as they are typed."""
    below = [action.choices for action in parser._actions if isinstance(action, argparse._SubParsersAction)]
    yield from (name for choices in below for one in choices.values() for name in leaves(one))
    if not below and "--json" in parser._option_string_actions:
        yield parser.prog.removeprefix("beckon ")


MISSING_CAMERA = ["--camera", "missing.json"]
REFUSED: dict[str, list[str]] = {
    "robot check": ["nonsense:robot"],
    "robot new": ["No Name"],
    "calibrate camera": ["missing.png", "--board", "9x6", "--square", "0.03"],
    "calibrate laser": ["missing", *MISSING_CAMERA],
    "calibrate array": ["missing.wav", "--array", "respeaker-4"],
    "calibrate board": ["--board", "9x6", "--square", "3"],
    "correct": ["missing.png", "--out", "here", *MISSING_CAMERA],
    "record": ["--robot", "nonsense:robot", "--out", "drive.mcap"],
    "slam": ["missing.bag"],
    "hear": ["missing.wav"],
    "look": ["missing.png", *MISSING_CAMERA],
    "speech-quality": ["--person", "missing.txt", "--robot", "missing.txt", "--marked"],
    "experiment": ["dead-reckoning-vs-slam", "--data", "missing.npz"],
    "models get": ["whisper-tiny.en", "missing.whl"],
    "models remove": ["whisper-tiny.en"],
    "settings": ["nonsense"],
    "link": ["--role", "nobody"],
    "token add": ["x", "--role", "nobody"],
    "token revoke": ["nobody"],
    "fleet cert": ["no name"],
    "fleet role": ["Ann", "r1", "nobody"],
    "backup": ["kept.tar.gz"],
    "restore": ["missing.tar.gz"],
}
"""A refusal of each command's own. Those that are left out answer whatever they are asked."""

COMMANDS = [name for name in leaves(build_parser()) if not name.startswith("experiment")] + ["experiment"]


def refused(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, dict[str, Any], str]:
    """Exit code, the one object and the last line on standard error of a command that refuses."""
    code = main([*arguments, "--json"])
    told = capsys.readouterr()
    return code, json.loads(told.out), told.err.splitlines()[-1]


@pytest.mark.parametrize("name", COMMANDS)
def test_what_a_command_refuses_is_one_object_with_a_sentence_and_its_code(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("BECKON_HOME", str(tmp_path / "home"))
    for wrong in (["--no-such-option"], REFUSED.get(name, ["--nor-this"])):
        code, answer, said = refused(capsys, *name.split(), *wrong)
        assert code in (1, 2) and said == f"beckon: {answer['error']}"
        assert " " in answer["error"] and answer["code"]


def test_only_commands_that_answer_everything_have_no_refusal_in_the_table() -> None:
    assert set(REFUSED) <= set(COMMANDS)
    assert set(COMMANDS) - set(REFUSED) == {"robots", "understand", "models list", "token list", "doctor"}


@pytest.mark.parametrize(
    ("trouble", "code"),
    [
        (Unavailable("Nothing is there."), "unavailable"),
        (PermissionError(13, "Permission denied", "file"), "system"),
        (ZeroDivisionError(), "internal"),
    ],
)
@pytest.mark.parametrize("begun", [False, True])
def test_whatever_fails_is_told_once_in_json_also_in_an_answer_that_was_begun(
    trouble: Exception, code: str, begun: bool, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(_: argparse.Namespace) -> int:
        if begun:
            with GrowingJson("files") as growing:
                growing.add({"heard": []}, "a.wav")
                raise trouble
        raise trouble

    monkeypatch.setattr(understand, "run", fail)
    ended, answer, said = refused(capsys, "understand", "stop")
    assert ended == 1 and said == f"beckon: {answer.pop('error')}" and answer.pop("code") == code
    assert answer == ({"files": {"a.wav": {"heard": []}}} if begun else {})
