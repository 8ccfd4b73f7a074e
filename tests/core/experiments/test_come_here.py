"""From a voice in the room to the wheels, through every part: minutes of simulated time."""

from __future__ import annotations

import importlib.util

import pytest

from core.speech.voice import can_speak
from tests.benchmarks.come_here import come, follow

pytestmark = pytest.mark.campaign


@pytest.mark.parametrize("seed", [0, 4])
def test_a_voice_brings_the_robot_to_half_a_metre(seed: int) -> None:
    row = come(seed, words=False)
    assert row["success"], row["why"]
    assert (row["contacts"], row["faults"]) == (0, [])


@pytest.mark.skipif(
    importlib.util.find_spec("pocketsphinx") is None or not can_speak(), reason="needs beckon[speech,voice]"
)
def test_the_spoken_words_bring_it_too() -> None:
    rows = [come(seed, words=True) for seed in (20, 21, 22)]
    understood = [row for row in rows if row["state"] != "not understood"]
    assert understood
    assert all(row["success"] for row in understood)


def test_it_follows_for_a_minute_while_somebody_else_crosses() -> None:
    row = follow(0, words=False)
    assert row["success"], row["why"]
    assert (row["contacts"], row["faults"]) == (0, [])
