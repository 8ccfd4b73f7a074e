"""The tour of the laboratory: short here, whole in the campaign."""

import dataclasses
import json
from pathlib import Path

import pytest

from core.experiments import EXPERIMENTS
from core.settings import Settings
from core.simulation.settings import SimulationSettings

BLIND = dataclasses.replace(Settings(), simulation=SimulationSettings(camera=False))


@pytest.mark.campaign
def test_the_beginning_of_the_tour_stays_on_its_way(tmp_path: Path) -> None:
    told: list[str] = []
    result = EXPERIMENTS["tour"](runs=1, seed=3, out=tmp_path, tell=told.append, settings=BLIND, minutes=0.4)
    assert (result["runs"], result["seed"]) == (1, 3)
    assert len(told) == 1
    assert result["estimators"]["ekf_slam"]["worst_error_m"] < 0.05
    assert result["estimators"]["dead_reckoning"]["mean_error_m"] > 0
    assert (result["contacts"], result["faults"]) == (0, [])
    assert result["tours"][0]["ends"]["done"] >= 2
    assert json.loads(Path(result["files"]["json"]).read_text())["estimators"] == result["estimators"]


@pytest.mark.campaign
def test_five_minutes_by_commands_only() -> None:
    """Error of the estimate far below dead reckoning's, honest about it, and nothing touched."""
    result = EXPERIMENTS["tour"](runs=4, seed=0)
    slam, wheels = result["estimators"]["ekf_slam"], result["estimators"]["dead_reckoning"]
    assert slam["worst_error_m"] < 0.03
    assert slam["mean_error_m"] < 0.2 * wheels["mean_error_m"]
    assert 2 < slam["nees_mean"] < 5
    assert (result["contacts"], result["faults"]) == (0, [])
    assert all(set(tour["ends"]) == {"done"} for tour in result["tours"])
