"""What strangers brought to calibrators, made small again: the answer is right, or a sentence names the cause."""

import json
from pathlib import Path

import numpy as np
import pytest

from core.calibration.board.board import Board
from core.calibration.files.camera_files import read_camera
from core.errors import BadInput
from core.pipelines.calibrate import calibrate_camera, calibrate_laser
from core.sensors.checks import CHECKS

pytestmark = pytest.mark.real_data
BOARD = Board(columns=8, rows=6, square=0.03)
TRUTH = {"fx": 520.0, "fy": 520.0, "cx": 322.0, "cy": 236.0}
REFUSED = {
    "kalibr_omni.yaml": "camera.other_model",
    "opencv_fisheye.yml": "camera.other_model",
    "ros_equi.yaml": "camera.other_model",
    "ros_fisheye.yaml": "camera.other_model",
    "ros_nomodel4.yaml": "camera.unnamed_model",
    "ros_plumb8bad.yaml": "camera.rational",
    "ros_rational.yaml": "camera.rational",
    "ros_binned.yaml": "camera.binned",
}


def begins(code: str) -> str:
    """A check's sentence up to its first value."""
    return CHECKS[code].sentence.split("{")[0]


@pytest.fixture(scope="module")
def strangers(shared_data: Path) -> Path:
    found = shared_data / "strangers"
    if not found.is_dir():
        pytest.skip("shared/data/strangers is not here")
    return found


@pytest.mark.parametrize(
    ("name", "code", "words"),
    [
        pytest.param("rot180", "camera.two_settings", "turned by half a turn", marks=pytest.mark.campaign),
        ("zoom", "camera.two_settings", "zoom or focus was moved"),
        ("fronto", "camera.focal_undecided", "do not decide the focal length"),
    ],
)
def test_pictures_that_no_single_camera_made_give_none(strangers: Path, name: str, code: str, words: str) -> None:
    with pytest.raises(BadInput, match=words) as told:
        calibrate_camera(sorted((strangers / "camera" / name).iterdir()), BOARD)
    assert str(told.value).startswith(begins(code))


def test_squares_that_are_not_square_are_measured(strangers: Path) -> None:
    told = calibrate_camera(sorted((strangers / "camera" / "aniso").iterdir()), BOARD)
    assert [each["code"] for each in told["faults"]] == ["board.unequal_squares"]
    assert "30.0 mm wide and 30.9 mm high" in told["warnings"][0]
    for name, value in TRUTH.items():
        assert abs(told[name] - value) < 3 * told["sd"][name]


def test_every_camera_file_is_read_right_or_refused_by_its_cause(strangers: Path) -> None:
    files = sorted((strangers / "camera_files").iterdir())
    assert len(files) > 10
    for path in files:
        if path.name in REFUSED:
            with pytest.raises(BadInput) as told:
                read_camera(path)
            assert begins(REFUSED[path.name]) in str(told.value), path.name
        elif path.name == "ros_rational_cols5.yaml":
            with pytest.raises(BadInput, match="1 x 5 numbers and holds 8"):
                read_camera(path)
        else:
            model = read_camera(path)
            assert model.fx in (520.0, 1040.0) and model.k1 in (-0.25, 0.0), path.name


def test_pairs_go_by_the_numbers_in_their_names_and_millimetres_are_named(strangers: Path) -> None:
    place, board = strangers / "laser", Board(columns=8, rows=6, square=0.08)
    truth = json.loads((place / "truth.json").read_text())
    told = calibrate_laser(place / "mixedpad", place / "cam.json", board)
    turn = np.array(told["rotation"]) @ np.array(truth["R"]).T
    assert told["poses_used"] == 12 and np.degrees(np.arccos((np.trace(turn) - 1) / 2)) < 0.5
    assert np.linalg.norm(np.array(told["translation_m"]) - truth["t"]) < 0.015
    with pytest.raises(BadInput, match="millimetres"):
        calibrate_laser(place / "mm", place / "cam.json", board)


@pytest.mark.parametrize("side", [0.025, 0.03])
def test_squares_of_another_size_are_not_told_as_a_unit_of_the_laser(strangers: Path, side: float) -> None:
    place = strangers / "laser"
    with pytest.raises(BadInput, match=r"only if their squares are about (79|80)") as told:
        calibrate_laser(place / "mixedpad", place / "cam.json", Board(columns=8, rows=6, square=side))
    assert "Measure five squares with a ruler" in str(told.value)
