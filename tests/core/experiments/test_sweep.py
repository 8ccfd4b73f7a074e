"""Sweeps over settings: every combination over the same seeds, and each as the experiment alone gives it."""

import csv
import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from core.errors import BadSettings
from core.experiments import EXPERIMENTS
from core.experiments import sweep as sweep_module
from core.experiments.campaign import Campaign
from core.experiments.plan import ExperimentPlan
from core.experiments.result import SPEED
from core.experiments.sweep import grid, sweep
from core.settings import Settings, changed

DRIVES = "dead-reckoning-vs-slam"


def test_a_grid_has_every_combination_in_order() -> None:
    assert grid(["ekf.gate=3,5.5", "ekf.mode=paper, invariant", "steering.x=true"]) == [
        {"ekf.gate": gate, "ekf.mode": mode, "steering.x": True}
        for gate in (3, 5.5)
        for mode in ("paper", "invariant")
    ]


@pytest.mark.parametrize(
    ("name", "given", "sentence"),
    [
        (DRIVES, [], "at least one --set"),
        (DRIVES, ["ekf.gate"], "SECTION.SETTING=A,B"),
        (DRIVES, ["ekf.gate="], "SECTION.SETTING=A,B"),
        (DRIVES, ["ekf.gate=3", "ekf.gate=4"], "given twice"),
        (DRIVES, ["ekf.gatte=3"], r"no setting ekf\.gatte; near are ekf\.gate"),
        (DRIVES, ["gate=3"], r"no setting gate; near are .*ekf\.gate"),
        (DRIVES, ["ekf.gate=-3"], r"\[ekf\] gate must lie between"),
        (DRIVES, ["ekf.mode=mine"], r"\[ekf\] mode must be one of"),
        (
            DRIVES,
            ["ekf.gate=" + ",".join(map(str, range(2, 40))), "ekf.misses=" + ",".join("123456789" * 4)],
            "too many",
        ),
        ("camera-table", ["ekf.gate=3"], "has no settings to sweep; those that have are .*tour"),
    ],
)
def test_what_cannot_be_swept_is_told_in_a_sentence(name: str, given: list[str], sentence: str) -> None:
    with pytest.raises(BadSettings, match=sentence):
        sweep(name, given, {"seed": 0})


@pytest.mark.campaign
def test_every_point_is_the_experiment_with_its_settings(tmp_path: Path) -> None:
    plan = sweep(DRIVES, ["ekf.range_sd=0.08,0.3"], {"seed": 4, "runs": 1})
    told: Any = Campaign("sweep-drives", 4, tmp_path, workers=1).carry_out(plan)
    assert [point["settings"] for point in told["points"]] == [{"ekf.range_sd": 0.08}, {"ekf.range_sd": 0.3}]
    errors = [point["figures"]["estimators.ekf_slam.mean_average_error_m"] for point in told["points"]]
    alone: Any = EXPERIMENTS[DRIVES](runs=1, seed=4, settings=changed(Settings(), {"ekf.range_sd": 0.3}))
    assert errors[1] == alone["estimators"]["ekf_slam"]["mean_average_error_m"] != errors[0]
    own = json.loads((tmp_path / "ekf.range_sd=0.3" / "dead_reckoning_vs_slam.json").read_text())
    assert own == {key: one for key, one in alone.items() if key not in ("text", "files", *SPEED)}
    assert json.loads((tmp_path / "sweep.json").read_text())["points"] == told["points"]
    with (tmp_path / "sweep.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["estimators.ekf_slam.mean_average_error_m"]) for row in rows] == errors
    head, *lines = told["text"].splitlines()
    assert head.split()[0] == "ekf.range_sd" and f"{errors[1]:.4g}" in lines[1].split()


def test_every_figure_that_a_sweep_shows_is_a_key_of_an_experiment_that_takes_settings() -> None:
    able = {name for name, one in EXPERIMENTS.items() if "settings" in one.options}
    assert able == {name for name, one in EXPERIMENTS.items() if one.about.swept}


def test_points_whose_names_differ_only_at_their_end_have_folders_of_their_own(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    folders = list[Path]()

    def finish(out: Path) -> dict[str, Any]:
        folders.append(out)
        return {"files": {}}

    about = SimpleNamespace(swept=())
    one = SimpleNamespace(options=("settings",), plan=lambda **_: ExperimentPlan((), finish), about=about)
    monkeypatch.setitem(EXPERIMENTS, "it", one)
    monkeypatch.setattr(sweep_module, "changed", lambda base, _: base)
    long = [f"section.setting_with_a_long_name_{number}={number}" for number in range(7)]
    sweep("it", [*long, "ekf.gate=3,5,9"], {"seed": 0}).finish([], tmp_path)
    assert len(set(folders)) == len(folders) == 3 and all(len(one.name) <= 200 for one in folders)
