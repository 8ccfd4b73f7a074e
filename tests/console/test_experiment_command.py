"""`beckon experiment`: tables and figures anew, from a seed."""

import json
from pathlib import Path

import cv2
import pytest

from console.__main__ import main


def test_table_3_is_printed_in_its_layout_and_drawn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["experiment", "camera-table", "--runs", "1", "--seed", "5"]
    assert main([*asked, "--out", str(tmp_path), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [row["parameter"] for row in told["table"]][:2] == ["f_u (pixels)", "f_v (pixels)"]
    assert "f_u (pixels)" in told["text"]
    assert (told["runs"], told["seed"]) == (1, 5)
    for name in ("figure_13", "figure_14", "figure_15"):
        drawn = cv2.imread(told["files"][name])
        assert drawn is not None and drawn.shape[1] >= 800 and (drawn < 250).any(axis=2).mean() > 0.02
    scene = Path(told["files"]["figure_15_scene"]).read_text()
    assert len(told["boards"]) == 20 and "<script" in scene and 'src="http' not in scene


@pytest.mark.campaign
def test_directions_are_an_experiment_of_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["experiment", "direction-of-arrival", "--runs", "1", "--seed", "2", "--out", str(tmp_path), "--json"]
    assert main(asked) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["seed"] == 2 and told["utterances"] >= 1 and Path(told["files"]["csv"]).is_file()
    assert set(told["estimators"]) == {
        "beckon",
        "beckon_alone",
        "beckon_first_0.35_s",
        "as_printed",
        "as_printed_alone",
    }


def test_a_folder_that_cannot_be_made_is_told_in_a_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("")
    assert main(["experiment", "camera-table", "--runs", "1", "--out", str(tmp_path / "file" / "x")]) == 1
    assert "cannot be made: Not a directory" in capsys.readouterr().err


def test_figure_16_is_an_experiment_of_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["experiment", "dead-reckoning-vs-slam", "--runs", "2", "--seed", "4", "--still", "--field", "camera"]
    assert main([*asked, "--noise", "0.5", "--workers", "1", "--out", str(tmp_path), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["runs"], told["seed"], told["setup"]["field"]) == (2, 4, "camera")
    assert told["setup"]["speed_sd_m_s"] == 0.1 and told["setup"]["still_start"] is True
    for name in ("dead_reckoning", "ekf_slam"):
        figures = {"worst_average_error_m", "mean_average_error_m", "worst_run", "path_m", "nees_mean"}
        assert figures <= told["estimators"][name].keys()
    assert all(Path(file).is_file() for file in told["files"].values())


@pytest.mark.parametrize(
    "wrong",
    [
        ["camera-table", "--still"],
        ["dead-reckoning-vs-slam", "--noise", "nan"],
        ["dead-reckoning-vs-slam", "--workers", "0"],
    ],
)
def test_what_an_experiment_does_not_take_is_wrong_usage(
    wrong: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["experiment", *wrong]) == 2
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.campaign
def test_all_runs_what_is_named_and_stores_its_figures_with_what_made_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = ["experiment", "all", "dead-reckoning-vs-slam", "--runs", "1", "--workers", "1", "--out", str(tmp_path)]
    assert main([*asked, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    done = told["experiments"]["dead-reckoning-vs-slam"]
    kept = json.loads(Path(done["file"]).read_text())
    assert kept["made_by"] == told["made_by"] and {"commit", "Beckon", "NumPy"} <= kept["made_by"].keys()
    assert (kept["runs"], kept["seed"], done["seed"]) == (1, 0, 0) and "text" not in kept
    assert kept["estimators"]["ekf_slam"]["worst_average_error_m"] > 0
    assert main(["experiment", "all"]) == 2 and "--out" in capsys.readouterr().err
