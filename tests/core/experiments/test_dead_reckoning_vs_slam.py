"""The paper's figure 16, on few runs."""

import csv
import json
import sys
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from core.errors import BadInput
from core.experiments import EXPERIMENTS, drives
from core.experiments.paper_course import CONTROL_UPDATES, UPDATES_PER_SIGHTING, Draws, mapped, paper_course, reckoned
from core.experiments.result import SPEED
from core.install import install_extra
from core.settings import read
from core.slam.ekf_slam import EkfSettings

PAPER = EkfSettings(mode="paper")
run = EXPERIMENTS["dead-reckoning-vs-slam"]


def test_the_drive_is_the_paper_s_three_metres_twenty_in_thirty_two_seconds() -> None:
    course = paper_course(0.10, 0.025, 0.1)
    assert len(course.speeds) == CONTROL_UPDATES and CONTROL_UPDATES * 0.025 == 32.0
    assert np.hypot(*np.diff(course.truth[:, :2], axis=0).T).sum() == pytest.approx(3.2)
    assert course.truth[-1] == pytest.approx((2.809, 0.702, np.radians(-38.3)), abs=1e-3)
    assert np.abs(course.steers).max() <= np.radians(30) + 1e-12


def test_controls_and_sightings_scatter_as_equation_43_says() -> None:
    course, drawn = paper_course(0.10, 0.025, 0.1), Draws(seed=3).run(0)
    assert np.std(drawn.speeds - course.speeds) == pytest.approx(0.2, rel=0.06)
    assert np.std(drawn.steers - course.steers) == pytest.approx(np.radians(1), rel=0.06)
    assert (
        sorted(drawn.seen) == list(range(UPDATES_PER_SIGHTING, CONTROL_UPDATES + 1, UPDATES_PER_SIGHTING))
        and len(drawn.still) == 10
    )
    away = [(k, course.landmarks[s.id] - course.truth[k, :2], s) for k, seen in drawn.seen.items() for s in seen]
    off = [s.range - np.hypot(*place) for _, place, s in away]
    assert np.std(off) == pytest.approx(0.08, rel=0.1)
    for k, place, s in away:
        bearing = s.bearing + course.truth[k, 2] - np.arctan2(place[1], place[0])
        assert abs((bearing + np.pi) % (2 * np.pi) - np.pi) < np.radians(5)


def test_the_camera_sees_fewer_corners_than_the_laser() -> None:
    seen = [sum(map(len, Draws(field=field).run(0).seen.values())) for field in ("laser", "camera")]
    assert 0 < seen[1] < 0.4 * seen[0]


def test_without_noise_dead_reckoning_follows_the_true_path() -> None:
    drawn = Draws().run(0)
    course = paper_course(0.10, 0.025, 0.1)
    exact = replace(drawn, speeds=course.speeds, steers=course.steers)
    assert reckoned(exact).errors.max() < 1e-9


def test_standing_still_first_makes_the_filter_better_and_both_better_than_the_wheels() -> None:
    trials = [Draws().run(number) for number in (3, 9)]
    wheels = np.mean([reckoned(one).average for one in trials])
    moving = np.mean([mapped(one, PAPER, still=False).average for one in trials])
    rested = np.mean([mapped(one, PAPER, still=True).average for one in trials])
    assert rested < 0.03 and rested < 0.6 * moving and moving < 0.5 * wheels


def test_a_seed_gives_the_same_answer_and_drawing_on_any_number_of_workers_with_every_figure(tmp_path: Path) -> None:
    alone = run(runs=2, seed=5, workers=1, out=tmp_path)
    beside = run(runs=2, seed=5, workers=2, out=tmp_path / "beside")
    assert (alone["workers"], beside["workers"]) == (1, 2)
    assert {key: one for key, one in alone.items() if key not in ("files", *SPEED)} == {
        key: one for key, one in beside.items() if key not in ("files", *SPEED)
    }
    drawn = [Path(told["files"]["figure_16"]).read_bytes() for told in (alone, beside)]
    assert drawn[0] == drawn[1]
    assert (alone["runs"], alone["seed"]) == (2, 5)
    for name in ("dead_reckoning", "ekf_slam", "ekf_slam_invariant"):
        row = alone["estimators"][name]
        assert 0 < row["mean_average_error_m"] <= row["worst_average_error_m"] and 0 <= row["worst_run"] < 2
        assert row["path_m"] == pytest.approx(3.2) and row["nees_mean"] > 0
    assert "paper" in alone["text"] and "0.20 m" in alone["text"]
    with Path(alone["files"]["csv"]).open() as file:
        rows = [row for row in csv.DictReader(file) if row["estimator"] == "ekf_slam"]
    worst = max(rows, key=lambda row: float(row["average_error_m"]))
    assert int(worst["run"]) == alone["estimators"]["ekf_slam"]["worst_run"]
    assert json.loads(Path(alone["files"]["json"]).read_text())["estimators"] == alone["estimators"]


@pytest.mark.campaign
def test_the_figure_has_four_panels_with_units_and_draws_the_worst_runs(tmp_path: Path) -> None:
    told = run(runs=2, out=tmp_path, still=True, settings=read('[ekf]\nmode = "invariant"'))
    assert told["setup"]["mode"] == "invariant" and "ekf_slam_paper" in told["estimators"]
    root = ElementTree.parse(told["files"]["figure_16"]).getroot()
    words = ["".join(each.itertext()) for each in root.iter("{http://www.w3.org/2000/svg}text")]
    assert [word[:3] for word in words if word.startswith("(")] == ["(a)", "(c)", "(b)", "(d)"]
    assert words.count("x [m]") == words.count("y [m]") == words.count("time [s]") == 2
    row = told["estimators"]["ekf_slam"]
    assert f"average {row['worst_average_error_m']:.3f} m, paper 0.08 m" in words
    assert f"worst of 2 runs: run {row['worst_run']}" in words
    assert any("R = diag(0.08 m, 1°)²" in word and "invariant form" in word for word in words)


@pytest.mark.campaign
def test_without_matplotlib_all_but_the_figure_is_written_and_the_extra_named(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    told = run(runs=1, out=tmp_path)
    assert set(told["files"]) == {"csv", "json", "runs"}
    assert all(Path(each).is_file() for each in told["files"].values())
    assert install_extra("figures") in told["not_drawn"]


def frozen_file(path: Path, **changes: Any) -> Path:
    """Two runs of the simulator in a file."""
    runs = [Draws(seed=1).run(number) for number in range(2)]
    obs = [(r.number, k, s.id, s.range, s.bearing) for r in runs for k, seen in r.seen.items() for s in seen]
    still = [(r.number, k, s.id, s.range, s.bearing) for r in runs for k, seen in enumerate(r.still) for s in seen]
    arrays = {
        "truth": runs[0].truth,
        "landmarks": runs[0].landmarks,
        "v_noisy": np.array([r.speeds for r in runs]),
        "steer_noisy": np.array([r.steers for r in runs]),
        "obs": np.array(obs),
        "still_obs": np.array(still),
    }
    np.savez(path, **(arrays | changes))
    return path


@pytest.mark.parametrize("still", [pytest.param(False, marks=pytest.mark.campaign), True])
def test_a_file_of_draws_gives_what_the_simulator_gave(tmp_path: Path, still: bool) -> None:
    path = frozen_file(tmp_path / "draws.npz")
    read_back, drawn = run(data=path, still=still), run(runs=2, seed=1, still=still)
    assert read_back["runs"] == 2 and read_back["estimators"] == drawn["estimators"]


def test_files_that_cannot_be_are_refused_in_sentences(tmp_path: Path) -> None:
    path = frozen_file(tmp_path / "draws.npz")
    with pytest.raises(BadInput, match="has 2 runs; 3 cannot be had"):
        run(data=path, runs=3)
    with pytest.raises(BadInput, match="leave out noise and field"):
        run(data=path, noise=2.0)
    with pytest.raises(BadInput, match=r"no file nothing\.npz"):
        run(data=tmp_path / "nothing.npz")
    for name, changes, sentence in (
        ("short", {"truth": np.zeros((9, 3))}, "should have 1281 poses"),
        ("blind", {"obs": np.zeros((0, 5))}, "Some runs in blind.npz have no sighting"),
        ("far", {"v_noisy": np.full((2, CONTROL_UPDATES), 1e300)}, "beyond"),
        ("restless", {"still_obs": np.zeros((0, 5))}, "no frames at rest"),
    ):
        with pytest.raises(BadInput, match=sentence):
            run(data=frozen_file(tmp_path / f"{name}.npz", **changes), still=True)


@pytest.mark.campaign
def test_through_its_sensors_the_robot_errs_by_centimetres(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(drives, "PATH_LENGTH_M", 0.3)
    told = run(runs=1, through="sensors", out=tmp_path)
    wheels, slam = told["estimators"]["dead_reckoning"], told["estimators"]["ekf_slam"]
    assert slam["worst_average_error_m"] < 0.03 and slam["path_m"] == pytest.approx(0.3, abs=0.01)
    assert wheels["worst_average_error_m"] > 0 and told["setup"]["ids"] == "hidden"
    assert Path(told["files"]["figure_16"]).read_text().count("<path") > 60
    with pytest.raises(BadInput, match="leave out data, noise, field, still, ids"):
        run(runs=1, through="sensors", still=True)


@pytest.mark.campaign
def test_through_its_sensors_no_run_of_forty_errs_by_five_centimetres() -> None:
    slam = run(runs=40, through="sensors")["estimators"]["ekf_slam"]
    assert slam["worst_average_error_m"] <= 0.05


def test_drives_that_broke_off_are_counted_and_told() -> None:
    planned: Any = EXPERIMENTS["dead-reckoning-vs-slam"].plan(runs=2)
    whole = planned.batches[0].work(0)
    short = replace(whole, path_m=dict.fromkeys(whole.path_m, 1.0))
    assert "short_drives" not in planned.finish([whole, whole], None)
    told = planned.finish([whole, short], None)
    assert told["short_drives"] == 1 and "1 ended before 3.2 m" in told["text"]
