"""`--out`: looked at before the work, and filled run by run."""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from console.__main__ import main
from console.cli import build_parser
from core.errors import Unwritable
from core.experiments import EXPERIMENTS, table_2
from core.experiments.run_log import RunLog
from core.experiments.side_by_side import side_by_side
from core.experiments.table_2_trials import TRIALS

REPOSITORY = Path(__file__).parents[2]


def parsers(parser: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    """A parser and all below it."""
    yield parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for below in action.choices.values():
                yield from parsers(below)


def test_every_subcommand_that_writes_looks_first_whether_it_can() -> None:
    writing = [parser for parser in parsers(build_parser()) if "--out" in parser._option_string_actions]
    assert len(writing) >= 8
    assert [parser.prog for parser in writing if parser.get_default("check_out") is None] == []


COMMANDS: dict[str, list[str]] = {
    "robot new": ["my_robot"],
    "slam": ["missing.bag"],
    "calibrate camera": ["missing.png", "--board", "9x6", "--square", "0.03"],
    "calibrate laser": ["missing", "--camera", "missing.json"],
    "calibrate array": ["missing.wav", "--array", "respeaker-4"],
    "calibrate board": ["--board", "9x6", "--square", "0.03"],
    "correct": ["missing.png", "--camera", "missing.json"],
    "speech-quality": ["--person", "missing.txt", "--robot", "missing.txt", "--marked"],
    **{f"experiment {name}": [] for name in EXPERIMENTS},
}


@pytest.mark.parametrize("name", COMMANDS)
def test_a_folder_that_cannot_be_written_is_told_before_anything_is_read_or_computed(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("")
    began = time.process_time()
    assert main([*name.split(), *COMMANDS[name], "--out", str(tmp_path / "file" / "x")]) == 1
    told = capsys.readouterr()
    assert told.out == "" and told.err.count("\n") == 1
    assert "Not a directory. Check the folder" in told.err and "missing" not in told.err
    assert time.process_time() - began < 2.0


def test_an_experiment_that_is_called_by_a_program_looks_first_too(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for run in EXPERIMENTS.values():
        with pytest.raises(Unwritable, match="Not a directory"):
            run(out=tmp_path / "file" / "x")


def rows_in(path: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in path.read_text().splitlines()]


def refuse_third(number: int) -> dict[str, int]:
    if number == 3:
        raise KeyboardInterrupt
    return {"figure": number}


def test_an_experiment_that_is_interrupted_keeps_the_runs_that_were_done(tmp_path: Path) -> None:
    told: list[str] = []
    log = RunLog(tmp_path / "new", "table-2", 8, 5, told.append)
    with pytest.raises(KeyboardInterrupt), log:
        side_by_side(refuse_third, 8, 1, None, log.add)
    path = Path(log.files["runs"])
    assert rows_in(path) == [
        {"experiment": "table-2", "runs": 8, "seed": 5},
        *({"done": number + 1, "of": 8, "figure": number} for number in range(3)),
    ]
    assert told == [f"Ended after 3 of 8 runs; their figures are in {path}."]


def test_the_runs_of_table_2_are_on_the_disk_as_they_are_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[int] = []

    def work(seed: int, runs: int, index: int) -> dict[str, Any]:
        found = list(tmp_path.glob("*.jsonl"))
        seen.append(len(rows_in(found[0])) - 1)
        if index == 2:
            raise KeyboardInterrupt
        return {"command": "turn_left", "run": index, "figure": None}

    monkeypatch.setattr(table_2, "_work", work)
    monkeypatch.setattr(table_2, "can_speak", lambda: True)
    with pytest.raises(KeyboardInterrupt):
        table_2.run(runs=1, out=tmp_path, workers=1)
    assert seen == [0, 1, 2]
    assert [row["of"] for row in rows_in(tmp_path / "table_2_runs.jsonl")[1:]] == [len(TRIALS)] * 2


def test_a_disk_that_fills_up_ends_it_with_a_sentence_and_what_was_done_stays(tmp_path: Path) -> None:
    limited = """
import resource, sys
from pathlib import Path
from core.experiments.run_log import RunLog
sys.dont_write_bytecode = True  # a compiled module that is cut off could not be imported any more
resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
try:
    with RunLog(Path(sys.argv[1]), "tour", 99, 0, print) as log:
        for number in range(99):
            log.add({"text": "x" * 500})
except Exception as trouble:
    print(type(trouble).__name__, trouble)
"""
    told = subprocess.run(
        [sys.executable, "-c", limited, str(tmp_path)], cwd=REPOSITORY, capture_output=True, text=True, check=True
    )
    assert "Ended after" in told.stdout and "of 99 runs" in told.stdout
    assert "Unwritable" in told.stdout and "File too large. Raise the limit" in told.stdout
    whole = (tmp_path / "tour_runs.jsonl").read_text().splitlines()[:-1]
    assert len(whole) >= 6 and all(json.loads(line) for line in whole)


def test_an_experiment_that_is_killed_keeps_its_runs(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "console", "experiment", "dead-reckoning-vs-slam", "--runs", "5000"]
    with subprocess.Popen(
        [*command, "--workers", "1", "--out", str(tmp_path)], cwd=REPOSITORY, stderr=subprocess.DEVNULL
    ) as process:
        path = tmp_path / "dead_reckoning_vs_slam_runs.jsonl"
        end = time.monotonic() + 60
        while not (path.exists() and path.read_text().count("\n") > 2) and time.monotonic() < end:
            time.sleep(0.05)
        os.kill(process.pid, signal.SIGKILL)
    lines = path.read_text().splitlines()
    assert json.loads(lines[0])["runs"] == 5000
    assert json.loads(lines[2]).keys() >= {"done", "of", "average_error_m"} and json.loads(lines[2])["done"] == 2
