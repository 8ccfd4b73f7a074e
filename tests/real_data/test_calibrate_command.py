"""The command line on real pictures and scans, with figures that other calibrators found too."""

import json
import time
from pathlib import Path
from typing import Any

import cv2
import pytest

from console.__main__ import main

pytestmark = pytest.mark.real_data
ACFR = {
    "image_size": [640, 480],
    "K": [[519.26845842, 0, 331.11197675], [0, 518.89359517, 229.43433605], [0, 0, 1]],
    "dist": [0.11418155, 0.19343114, -0.00268067, 0.00371577, -1.09539701],
}


def told(capsys: pytest.CaptureFixture[str], *arguments: object) -> dict[str, Any]:
    assert main([*map(str, arguments), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def left(shared_data: Path) -> list[Path]:
    return sorted((shared_data / "chessboard-opencv-left").glob("left*.jpg"))


def test_the_left_camera_is_found_with_all_its_deviations_and_its_files_straighten_pictures(
    shared_data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pictures = left(shared_data)
    board = ("--board", "9x6", "--square", "0.025")
    found = told(capsys, "calibrate", "camera", *pictures, *board, "--out", tmp_path / "camera")
    assert found["image_size"] == [640, 480] and found["views_used"] == 13 and found["views_refused"] == []
    assert abs(found["fx"] - 533.1) < 1 and abs(found["fy"] - 533.1) < 1 and found["rms_px"] <= 0.21
    assert set(found["sd"]) == {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"} and "k3" not in found
    assert all(sd > 0 for sd in found["sd"].values()) and 0.35 <= found["sd"]["fx"] <= 0.5
    for form in ("ros", "opencv", "json", "kalibr"):
        out = tmp_path / form
        straight = told(capsys, "correct", pictures[0], "--camera", found["files"][form], "--out", out)
        assert cv2.imread(straight["pictures"][0]["file"]).shape[:2] == (480, 640)


def test_miscounted_squares_are_noticed_and_named(shared_data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    asked = ["calibrate", "camera", *map(str, left(shared_data)[:4]), "--board", "10x7", "--square", "0.025"]
    assert main(asked) == 1
    assert "9x6 inner corners, not 10x7" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("square", "doubted"), [pytest.param("0.019", False, marks=pytest.mark.campaign), ("0.020", True)]
)
def test_upright_boards_leave_height_roll_and_pitch_open_and_the_laser_measures_the_squares(
    shared_data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], square: str, doubted: bool
) -> None:
    camera = tmp_path / "camera.json"
    camera.write_text(json.dumps(ACFR))
    asked = ["calibrate", "laser", shared_data / "camera-lidar2d-acfr", "--camera", camera]
    asked += ["--board", "11x8", "--square", square]
    found = told(capsys, *asked)
    assert found["poses_used"] == 5 and found["poses_refused"] == [] and len(found["rotation"]) == 3
    weak = " ".join(found["weak_directions"])
    assert all(f"{name} (" in weak for name in ("roll", "pitch", "height"))
    assert found["square_m"]["by_laser"] == pytest.approx(0.0189, abs=0.0002)
    assert any("squares are 18.9" in each and "not 20.0 mm" in each for each in found["warnings"]) is doubted
    assert main([*map(str, asked), "--out", str(tmp_path / "mount")]) == 0
    printed = capsys.readouterr().out
    for name in ("roll (degrees)", "pitch (degrees)", "height (metres)"):
        line = next(each for each in printed.splitlines() if each.startswith(name))
        assert line.split(")")[1].split() == ["not", "known"]
    assert "The laser believes the squares are 18.9" in " ".join(printed.split())
    assert "static_transform_publisher" not in printed
    assert json.loads((tmp_path / "mount" / "mount.json").read_text())["extrinsics"]["not_known"]


def test_a_measured_height_is_taken_as_measured(
    shared_data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    camera = tmp_path / "camera.json"
    camera.write_text(json.dumps({"camera": ACFR, "board": {"inner_corners": [11, 8], "square_m": 0.02}}))
    asked = ["calibrate", "laser", str(shared_data / "camera-lidar2d-acfr"), "--camera", str(camera)]
    assert main([*asked, "--square", "0.019", "--height", "0.05", "--offset"]) == 0
    rows = {line[:26].strip(): line[26:].split() for line in capsys.readouterr().out.splitlines()}
    assert rows["height (metres)"] == ["by", "ruler"] and rows["roll (degrees)"] == ["as", "level"]
    assert float(rows["yaw (degrees)"][0]) == pytest.approx(1.15, abs=0.4)
    assert len(rows["range offset (metres)"]) == 2


def test_malformed_pictures_are_named_with_their_reasons_in_no_time(
    shared_data: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bad = [path for path in sorted((shared_data / "malformed").iterdir()) if path.suffix in (".jpg", ".png")]
    begun = time.process_time()
    found = told(capsys, "calibrate", "camera", *left(shared_data)[:6], *bad, "--board", "9x6", "--square", "0.025")
    assert time.process_time() - begun < 2
    assert found["views_used"] == 6
    reasons = {each["image"]: each["reason"] for each in found["views_refused"]}
    assert set(reasons) == {path.name for path in bad}
    assert "20000x20000" in reasons["lying_header_20000x20000.jpg"] and "cut off" in reasons["truncated_40pct.png"]
    assert main(["calibrate", "camera", *map(str, bad), "--board", "9x6", "--square", "0.025"]) == 1
    assert "Only 0 of" in capsys.readouterr().err


@pytest.mark.parametrize(
    "name", ["calib_missing_keys.json", "calib_nan.json", "alias_bomb.yaml", "scan_problems.jsonl"]
)
def test_malformed_cameras_end_in_a_sentence(
    shared_data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    camera, picture = str(shared_data / "malformed" / name), str(left(shared_data)[0])
    for asked in (
        ["correct", picture, "--camera", camera, "--out", str(tmp_path)],
        ["calibrate", "laser", str(shared_data / "camera-lidar2d-acfr"), "--camera", camera],
    ):
        assert main(asked) == 1
        said = capsys.readouterr()
        assert said.out == "" and said.err.count("\n") == 1 and name in said.err
        assert "something went wrong" not in said.err
