"""From a voice in the room to the wheels, through every part; most of it takes minutes of simulated time."""

import importlib.util
import json
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

from core.experiments import EXPERIMENTS, table_2
from core.experiments.table_2 import TRIALS, summary, trial, voice_figures
from core.speech.synthesis import ENGLISH_VOICES, NATURAL_WORDS_MIN, can_speak, drawn_voice

understands = pytest.mark.skipif(
    importlib.util.find_spec("pocketsphinx") is None or not can_speak(), reason="needs the extra speech and voice"
)


@pytest.mark.parametrize(
    "name", ["turn_left", *(pytest.param(name, marks=pytest.mark.campaign) for name in ("continue", "stop_at"))]
)
def test_what_a_voice_asks_for_is_done(name: str) -> None:
    row = trial(name, 0, 1, words=False)
    assert row["success"], row["why"]
    assert (row["contacts"], row["faults"], row["wrong"]) == (0, [], [])
    assert row["wheels_s"] is not None and 0 <= row["wheels_s"] < 2


def test_the_row_of_a_command_counts_who_was_not_understood_as_a_failure() -> None:
    row = {"success": True, "understood": True, "tries": 2, "figure": 0.5, "contacts": 0, "run": 0}
    row |= {"world": "lab", "words": "turn left", "why": ""}
    lost = row | {"success": False, "understood": False, "figure": None, "why": "not understood"}
    told = summary("turn_left", [row, row | {"tries": 1, "figure": 0.7}, lost, lost])
    assert (told["success_rate"], told["understood_rate"], told["understood_at_once_rate"]) == (0.5, 0.5, 0.25)
    assert told["success_rate_of_understood"] == 1.0
    assert (told["median"], told["worst"]) == (0.6, 0.7)
    assert len(told["failures"]) == 2


def test_success_is_told_by_voice() -> None:
    rows = [
        {"voice": voice, "success": good, "understood": True}
        for voice, good in (("en-us+m1", True), ("en-us+m1", False), ("en-029", True))
    ]
    told = voice_figures(cast(Any, rows))
    assert told["en-us+m1"] == {"runs": 2, "success_rate": 0.5, "understood_rate": 1.0}
    assert told["en-029"]["success_rate"] == 1.0


def test_voices_are_drawn_from_all_english_ones_at_their_natural_pace() -> None:
    chance = np.random.default_rng(0)
    drawn = [drawn_voice(chance) for _ in range(400)]
    assert {one.voice for one in drawn} == set(ENGLISH_VOICES)
    assert all(0.84 * NATURAL_WORDS_MIN < one.speed < 1.16 * NATURAL_WORDS_MIN for one in drawn)


@pytest.mark.campaign
@understands
def test_the_table_of_one_command_is_saved(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(table_2, "TRIALS", {"turn_left": TRIALS["turn_left"]})
    result = EXPERIMENTS["table-2"](runs=1, seed=3, out=tmp_path, workers=1)
    assert set(result["commands"]) == {"turn_left"} and result["wrong_motions"] == result["contacts"] == 0
    assert "turn_left" in result["text"] and "given: " in result["text"]
    assert result["best_voice"] in result["voices"]
    assert json.loads(Path(result["files"]["json"]).read_text())["commands"] == result["commands"]
    assert len(Path(result["files"]["csv"]).read_text().splitlines()) == 2


@pytest.mark.campaign
@pytest.mark.parametrize("number", [0, 4])
def test_a_voice_brings_the_robot_to_half_a_metre(number: int) -> None:
    row = trial("come_here", number, 0, words=False)
    assert row["success"], row["why"]
    assert (row["contacts"], row["faults"]) == (0, [])


@pytest.mark.campaign
@understands
def test_the_spoken_words_bring_it_too() -> None:
    rows = [trial("come_here", number, 0) for number in (20, 21, 22)]
    understood = [row for row in rows if row["understood"]]
    assert understood
    assert all(row["success"] for row in understood)


@pytest.mark.campaign
def test_it_follows_for_a_minute_while_someone_else_crosses() -> None:
    row = trial("follow_me", 0, 0, words=False)
    assert row["success"], row["why"]
    assert (row["contacts"], row["faults"]) == (0, [])


@pytest.mark.campaign
@understands
def test_every_command_of_the_table_is_spoken_once(tmp_path: Path) -> None:
    result = EXPERIMENTS["table-2"](runs=1, seed=0, out=tmp_path)
    assert set(result["commands"]) == set(TRIALS)
    assert (result["contacts"], result["faults"]) == (0, [])
    assert result["wrong_motions"] == 0, result["wrong"]
    understood = [one for one in result["commands"].values() if one["understood_rate"] == 1.0]
    assert len(understood) >= 6  # of voices drawn from all: one run of each command tells no rate
    assert sum(one["success_rate"] for one in understood) >= len(understood) - 1
