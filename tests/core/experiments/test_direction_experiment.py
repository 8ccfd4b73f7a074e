"""The experiment of directions: seeded, written down, and ours before the paper's."""

import csv
import json
from typing import Any

import numpy as np
import pytest

from core.experiments import EXPERIMENTS
from core.experiments.direction_ablation import ablated
from core.experiments.direction_of_arrival import ARRAYS, trials
from core.experiments.talk_in_rooms import make_scene
from core.speech.practice_voice import practice_voice


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Any:
    return EXPERIMENTS["direction-of-arrival"](runs=40, seed=3, out=tmp_path_factory.mktemp("direction"))


@pytest.mark.campaign
def test_ours_is_better_than_as_printed_on_the_same_sounds(result: Any) -> None:
    ours, printed = (result["estimators"][name]["all"] for name in ("beckon", "as_printed"))
    assert result["utterances"] == ours["utterances"] == printed["utterances"] == 40
    assert ours["median_deg"] < 2 and ours["beyond_10_deg"] <= 0.1
    assert printed["median_deg"] > 3 * ours["median_deg"]  # with the same knowledge of when the speech begins
    alone, theirs = (result["estimators"][name]["all"] for name in ("beckon_alone", "as_printed_alone"))
    assert theirs["median_deg"] > 2 * alone["median_deg"]
    assert "when the speech begins" in result["conditions"]
    assert ours["within_2_sd"] >= 0.85 and ours["declared"] > 0.9  # 0.90 to 0.99 takes 200 utterances, not 40


@pytest.mark.campaign
def test_each_difference_from_the_print_is_taken_away_alone() -> None:
    rng = np.random.default_rng(6)
    scene = make_scene(rng, 0.3, practice_voice(rng, 1.5, 16000), list(ARRAYS.values()))
    done = trials(scene, ablated(), (("diffuse", 10.0),))
    errors = {name: [one.error for one in done if one.estimator == name] for name in ablated()}
    declared = {name: sum(one.declared for one in done if one.estimator == name) for name in errors}
    assert errors["any_misfit"] == errors["beckon"]  # it declares more of the same
    assert declared["any_misfit"] >= declared["beckon"]
    assert len({tuple(one) for one in errors.values()}) == len(errors) - 1
    assert max(errors["tracked"]) < 0.2


def test_every_cell_and_every_trial_is_written_down(result: Any) -> None:
    with open(result["files"]["csv"], newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 5 * 40 and {row["array"] for row in rows} == {"square", "tetrahedron"}
    with open(result["files"]["json"]) as file:
        whole = json.load(file)
    assert len(whole["cells"]["beckon"]) == 40
    errors = [float(row["error_deg"]) for row in rows if row["estimator"] == "beckon"]
    assert np.median(errors) == pytest.approx(whole["estimators"]["beckon"]["all"]["median_deg"], rel=1e-3)


def test_the_made_up_voice_is_seeded_and_holds_speech_like_power() -> None:
    one, same = (practice_voice(np.random.default_rng(2), 2.0, 16000) for _ in range(2))
    assert np.array_equal(one, same) and len(one) == 32000 and np.isfinite(one).all()
    power = np.abs(np.fft.rfft(one)) ** 2
    hertz = np.fft.rfftfreq(len(one), 1 / 16000)
    assert power[(hertz > 100) & (hertz < 4000)].sum() > 0.8 * power.sum()
