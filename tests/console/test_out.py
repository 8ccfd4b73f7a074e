"""`--out`: looked at before the work, and filled run by run."""

import argparse
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from console.__main__ import main
from console.cli import build_parser
from core.errors import Unwritable
from core.experiments import EXPERIMENTS
from core.experiments.result import SPEED

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


def test_a_disk_that_fills_up_ends_it_with_a_sentence_and_what_was_done_stays(tmp_path: Path) -> None:
    limited = """
import resource, sys
from pathlib import Path
from core.experiments.campaign import Campaign
from core.experiments.plan import ExperimentPlan, RunBatch
sys.dont_write_bytecode = True  # a compiled module that is cut off could not be imported any more
resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
plan = ExperimentPlan((RunBatch(lambda number: {"text": "x" * 500}, 99, dict),), None)
try:
    Campaign("tour", out=Path(sys.argv[1]), tell=print, workers=1).carry_out(plan)
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


@pytest.mark.campaign
def test_an_experiment_that_is_killed_keeps_its_runs_and_resumes_with_the_others(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = ["experiment", "dead-reckoning-vs-slam", "--runs", "4", "--workers", "1", "--out", str(tmp_path)]
    path = tmp_path / "dead_reckoning_vs_slam_runs.jsonl"
    with subprocess.Popen(
        [sys.executable, "-m", "console", *asked], cwd=REPOSITORY, stderr=subprocess.DEVNULL
    ) as process:
        end = time.monotonic() + 120
        while not (path.exists() and path.read_text().count("\n") > 2) and time.monotonic() < end:
            time.sleep(0.02)
        os.kill(process.pid, signal.SIGKILL)
    kept = path.read_text().count("\n") - 1
    assert main([*asked, "--resume", "--json"]) == 0
    resumed = json.loads(capsys.readouterr().out)
    assert 2 <= resumed["resumed_runs"] == kept <= 4
    shutil.rmtree(tmp_path)
    assert main([*asked, "--json"]) == 0
    whole = json.loads(capsys.readouterr().out)
    assert {key: one for key, one in resumed.items() if key not in SPEED} == {
        key: one for key, one in whole.items() if key not in SPEED
    }
    assert main([*asked[:2], "--resume", "--runs", "1"]) == 2
    assert "--out DIR" in capsys.readouterr().err
