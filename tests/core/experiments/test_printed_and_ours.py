"""The chapter's forms beside ours: a command spoken in either form; the table from given figures."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import pytest

from core.experiments import dead_reckoning_vs_slam, printed_and_ours
from core.experiments.drives import FIGURED, PLAIN
from core.experiments.printed_and_ours import Column, SpokenCommands, run
from core.experiments.table_2_trials import TRIALS
from core.speech.synthesis import can_speak

speaking = pytest.mark.skipif(not can_speak(), reason="needs the extra voice")
understands = pytest.mark.skipif(
    importlib.util.find_spec("pocketsphinx") is None or not can_speak(), reason="needs the extra speech and voice"
)


@understands
@pytest.mark.parametrize(
    ("column", "command"), [("printed", "come_here"), pytest.param("ours", "turn_right", marks=pytest.mark.campaign)]
)
def test_a_spoken_command_is_carried_out_in_either_form(column: Column, command: str) -> None:
    number = tuple(TRIALS).index(command)
    assert SpokenCommands(column, seed=0, runs=1)(number) == (True, 0)


@speaking
def test_the_table_has_the_drive_and_every_command_in_both_columns(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    modes: list[str] = []

    def drives(**given: Any) -> dict[str, Any]:
        modes.append(given["settings"].chapter.mode)
        row = {"worst_average_error_m": 0.2, "mean_average_error_m": 0.1, "mean_final_error_m": 0.1, "nees_mean": 3.0}
        return {"estimators": {FIGURED: row, PLAIN: row}}

    def trials(work: SpokenCommands, count: int, *_: object) -> list[tuple[bool, int]]:
        return [(work.column == "ours" or number % 2 == 0, 0) for number in range(count)]

    monkeypatch.setattr(dead_reckoning_vs_slam, "run", drives)
    monkeypatch.setattr(printed_and_ours, "side_by_side", trials)
    result = run(runs=2, out=tmp_path)
    assert modes == ["printed", "ours"]
    assert result["commands"] == {key: {"printed": 0.5, "ours": 1.0} for key in TRIALS}
    assert result["contacts"] == {"printed": 0, "ours": 0}
    assert all(name in result["text"] for name in TRIALS)
    assert (tmp_path / "printed_and_ours.json").exists()
