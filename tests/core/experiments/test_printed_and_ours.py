"""The chapter's forms beside ours: a command spoken in either form; the table from given figures."""

import importlib.util
from pathlib import Path
from typing import Any

import pytest

from core.experiments import EXPERIMENTS
from core.experiments.dead_reckoning_vs_slam import DriveOutcome
from core.experiments.drives import FIGURED, PLAIN
from core.experiments.printed_and_ours import COLUMNS, Column
from core.experiments.table_2 import trial_of
from core.experiments.table_2_trials import TRIALS
from core.speech.synthesis import can_speak

speaking = pytest.mark.skipif(not can_speak(), reason="needs the extra voice")
understands = pytest.mark.skipif(
    importlib.util.find_spec("pocketsphinx") is None or not can_speak(), reason="needs the extra speech and voice"
)


@understands
@pytest.mark.parametrize(
    ("column", "command"), [pytest.param("printed", "come_here", marks=pytest.mark.campaign), ("ours", "turn_right")]
)
def test_a_spoken_command_is_carried_out_in_either_form(column: Column, command: str) -> None:
    number = tuple(TRIALS).index(command)
    row = trial_of(0, 1, COLUMNS[column], number)
    assert (row["success"], row["contacts"]) == (True, 0), row["why"]


@speaking
def test_the_table_has_the_drive_and_every_command_in_both_columns(tmp_path: Path) -> None:
    drive = DriveOutcome(
        average_error_m={FIGURED: 0.1, PLAIN: 0.2},
        path_m={FIGURED: 3.2, PLAIN: 3.2},
        final_error_m={FIGURED: 0.1, PLAIN: 0.2},
        nees={FIGURED: 3.0, PLAIN: 3.0},
        errors={},
        places={},
    )
    plan = EXPERIMENTS["printed-and-ours"].plan(runs=2)
    works: list[Any] = [batch.work for batch in plan.batches[1::2]]
    assert [work.args[-1].chapter.mode for work in works] == ["printed", "ours"]
    answers: list[Any] = []
    for column in COLUMNS:
        spoken = [{"success": column == "ours" or n % 2 == 0, "contacts": 0} for n in range(2 * len(TRIALS))]
        answers += [drive, drive, *spoken]
    assert plan.count == len(answers)
    result: Any = plan.finish(answers, tmp_path)
    assert result["commands"] == {key: {"printed": 0.5, "ours": 1.0} for key in TRIALS}
    assert result["contacts"] == {"printed": 0, "ours": 0}
    assert all(name in result["text"] for name in TRIALS)
    assert (tmp_path / "printed_and_ours.json").exists()
