"""`beckon calibrate` and `beckon correct`: what they answer, what they leave, and sentences instead of tracebacks."""

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from console.__main__ import main
from core.calibration.board.board import Board
from core.calibration.board.chessboard import find_board
from core.calibration.files.camera_files import camera_entry, read_camera, ros_yaml
from core.calibration.practice import BoardPlacement, held, picture
from core.optics import TABLE_3, CameraModel

BOARD = Board(columns=9, rows=6, square=0.03)
ASKED = ["--board", "9x6", "--square", "0.03"]


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    folder = tmp_path_factory.mktemp("pictures")
    rng = np.random.default_rng(21)
    poses = held(rng, 8, TABLE_3, BOARD, BoardPlacement(nearest=0.25, farthest=0.6, margin=10))
    paths = [folder / f"view{number}.png" for number in range(8)]
    for number, path in enumerate(paths):
        cv2.imwrite(str(path), picture(rng, TABLE_3, poses.take(slice(number, number + 1)), BOARD))
    return [str(path) for path in paths]


@pytest.fixture
def camera(tmp_path: Path) -> str:
    file = tmp_path / "camera.json"
    file.write_text(json.dumps(camera_entry(TABLE_3)))
    return str(file)


def answer(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    """Exit code, standard output and standard error of a command."""
    code = main([str(each) for each in arguments])
    told = capsys.readouterr()
    assert "Traceback" not in told.err and "something went wrong" not in told.err
    return code, told.out, told.err


def test_json_is_one_object_and_progress_goes_to_standard_error(
    pictures: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out, err = answer(capsys, "calibrate", "camera", *pictures, *ASKED, "--out", str(tmp_path), "--json")
    told = json.loads(out)
    assert code == 0 and told["image_size"] == [320, 256] and told["views_used"] + len(told["views_refused"]) == 8
    assert set(told["sd"]) >= {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"} <= set(told)
    assert abs(told["fx"] - TABLE_3.fx) < 4 * told["sd"]["fx"] + 0.2
    assert all(read_camera(Path(told["files"][form])).fx == told["fx"] for form in ("ros", "opencv", "json"))
    assert "looking" not in out and "{" not in err


def test_corners_by_hand_take_a_picture_in_that_the_finder_leaves_out(
    pictures: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    grey: Any = cv2.imread(pictures[0], cv2.IMREAD_GRAYSCALE)
    found = find_board(grey, BOARD)
    assert found is not None
    covered = tmp_path / "covered.png"
    cv2.imwrite(str(covered), cv2.circle(grey, np.rint(found.corners[22]).astype(int).tolist(), 12, 127, -1))
    given = tmp_path / "corners.json"
    given.write_text(json.dumps({"covered.png": (found.corners[[0, 8, 53, 45]] + 1).tolist()}))
    asked = ["calibrate", "camera", str(covered), *pictures[1:5], *ASKED, "--json"]
    refused = [
        json.loads(answer(capsys, *asked, *more)[1])["views_refused"] for more in ((), ("--corners", str(given)))
    ]
    assert [one["image"] for one in refused[0]] == ["covered.png"] and refused[1] == []
    for text in ("no", '{"covered.png": [[1, 2]]}', '{"other.png": [[1, 2], [3, 4], [5, 6], [7, 8]]}'):
        given.write_text(text)
        code, _, err = answer(capsys, *asked[:-1], "--corners", str(given))
        assert code == 1 and "corners.json" in err


def test_people_get_table_3_and_the_reason_for_every_refused_view(
    pictures: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "text.png").write_text("no picture")
    extra = [str(tmp_path / "text.png"), str(tmp_path), str(tmp_path / "none.png"), pictures[0]]
    code, out, _ = answer(capsys, "calibrate", "camera", *pictures, *extra, *ASKED)
    lines = out.splitlines()
    assert code == 0 and "9x6 board with 30 mm squares" in lines[0]
    assert lines[2].split() == ["Parameter", "Value", "standard", "dev."]
    assert [line.split()[0] for line in lines[3:11]] == [
        "f_u",
        "f_v",
        "u_0",
        "v_0",
        "k1(r)",
        "k2(r)",
        "k1(t)",
        "k2(t)",
    ]
    assert all(len(line) <= 110 for line in lines)
    refused = out[out.index("Not used") :]
    for words in ("this is no JPEG", "it is a folder", "no such file", "same picture as view0.png"):
        assert words in refused
    assert "Nothing was saved; --out DIR keeps it." in out


@pytest.mark.parametrize(
    "arguments",
    [
        ["--board", "9", "--square", "0.03"],
        ["--board", "9x", "--square", "0.03"],
        ["--board", "1x1", "--square", "0.03"],
        ["--board", "200x200", "--square", "0.03"],
        ["--board", "9x6x3", "--square", "0.03"],
        ["--board", "9x6", "--square", "0"],
        ["--board", "9x6", "--square", "-0.03"],
        ["--board", "9x6", "--square", "nan"],
        ["--board", "9x6", "--square", "30"],
        ["--board", "9x6", "--square", "30mm"],
        ["--board", "9x6", "--square", "0.03", "--panel", "0.1x0.1"],
        ["--board", "9x6", "--square", "0.03", "--panel", "wide"],
        ["--board", "9x6"],
        ["--square", "0.03"],
        [],
    ],
)
def test_a_wrong_board_is_wrong_usage_in_a_sentence(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = answer(capsys, "calibrate", "camera", "view.png", *arguments)
    assert code == 2 and out == "" and "\nbeckon: " in err
    assert "invalid" not in err and len(err.splitlines()[-1]) > 40


@pytest.mark.parametrize(
    "arguments",
    [
        ["calibrate"],
        ["calibrate", "lens"],
        ["calibrate", "camera", *ASKED],
        ["calibrate", "laser"],
        ["calibrate", "laser", "folder"],
        ["calibrate", "laser", "folder", "--camera", "camera.json", "--height", "nan"],
        ["calibrate", "laser", "folder", "--camera", "camera.json", "--height", "high"],
        ["calibrate", "board", "--board", "9x6"],
        ["calibrate", "board", *ASKED, "--page", "A0"],
        ["correct", "view.png", "--camera", "camera.json"],
        ["correct", "view.png", "--camera", "camera.json", "--out", "o", "--method", "best"],
        ["experiment", "camera-table", "--runs", "0"],
        ["experiment", "camera-table", "--runs", "-3"],
        ["experiment", "camera-table", "--runs", "many"],
        ["experiment", "camera-table", "--seed", "-1"],
        ["experiment", "table-9"],
    ],
)
def test_other_wrong_usage(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = answer(capsys, *arguments)
    assert code == 2 and out == "" and "\nbeckon: " in err


def test_what_cannot_be_done_is_told_in_one_sentence(
    pictures: list[str], camera: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    calibrate, laser, correct = ["calibrate", "camera"], ["calibrate", "laser"], ["correct"]
    a_file = tmp_path / "file"
    a_file.write_text("")
    (tmp_path / "bare" / "images").mkdir(parents=True)
    nothing = str(tmp_path / "none")
    with_camera, to = ["--camera", camera], ["--out", str(tmp_path / "out")]
    tried = {
        "Only 0 of 1": [*calibrate, nothing, *ASKED],
        "it is a folder": [*calibrate, str(tmp_path), *ASKED],
        "same picture": [*calibrate, *[pictures[0]] * 4, *ASKED],
        "Only 2 of 2": [*calibrate, *pictures[:2], *ASKED],
        "squares instead of inner corners": [*calibrate, *pictures[:3], "--board", "10x7", "--square", "0.03"],
        "cannot be made": [*calibrate, *pictures, *ASKED, "--out", str(a_file / "below")],
        "There is no folder": [*laser, nothing, *with_camera, *ASKED],
        "needs a folder images/": [*laser, str(tmp_path), *with_camera, *ASKED],
        "0 pictures and 0 scans": [*laser, str(tmp_path / "bare"), *with_camera, *ASKED],
        "which board was used": [*laser, str(tmp_path), *with_camera],
        "There is no camera file": [*laser, str(tmp_path), "--camera", nothing],
        "No picture could be corrected": [*correct, str(a_file), *with_camera, *to],
        "no camera": [*correct, pictures[0], "--camera", pictures[0].replace("view0.png", "."), *to],
        "does not fit A4": ["calibrate", "board", *ASKED, "--page", "A4"],
        "does not fit A3": ["calibrate", "board", "--board", "40x40", "--square", "0.1"],
        "cannot be written": ["calibrate", "board", *ASKED, "--out", str(tmp_path)],
        "File name too long": [*correct, pictures[0], "--camera", "x" * 5000, *to],
    }
    for sentence, arguments in tried.items():
        code, out, err = answer(capsys, *arguments, "--json")
        last = err.splitlines()[-1]
        assert code == 1, sentence
        assert not out or last == f"beckon: {json.loads(out)['error']}", sentence
        assert sentence in last and last.startswith("beckon: ")


def test_pictures_are_straightened_either_way_and_never_over_each_other(
    pictures: list[str], camera: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    twin = tmp_path / "view0.bmp"
    cv2.imwrite(str(twin), cv2.imread(pictures[1]))
    for method in ("exact", "table-1"):
        out = tmp_path / method
        arguments = ["correct", pictures[0], str(twin), "none.png", "--camera", camera, "--out", str(out)]
        code, text, _ = answer(capsys, *arguments, "--method", method, "--json")
        told = json.loads(text)
        assert code == 0 and told["method"] == method
        assert told["error"]["table_1"]["max_px"] <= 0.42 and told["error"]["exact"]["max_px"] <= 1e-3
        files = [each["file"] for each in told["pictures"]]
        assert sorted(path.name for path in out.iterdir()) == ["view0_straight.png", "view0_straight_2.png"]
        assert (cv2.imread(files[0]) != cv2.imread(files[1])).any()
        assert told["pictures_refused"] == [{"image": "none.png", "reason": "there is no such file"}]
        code, text, _ = answer(capsys, *arguments, "--method", method)
        assert text.startswith("2 of 3 pictures straightened") and "px at most" in text


def test_pictures_are_straightened_by_an_improbable_camera_with_a_warning(
    pictures: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    height, width = cv2.imread(pictures[0]).shape[:2]
    model = CameraModel(width=width, height=height, fx=0.9 * width, fy=1.2 * width, cx=width / 2, cy=height / 2)
    (tmp_path / "odd.yaml").write_text(ros_yaml(model))
    code, text, _ = answer(
        capsys, "correct", pictures[0], "--camera", str(tmp_path / "odd.yaml"), "--out", str(tmp_path), "--json"
    )
    told = json.loads(text)
    assert code == 0 and [one["code"] for one in told["faults"]] == ["camera.focal_ratio"]
    assert told["warnings"] == [told["faults"][0]["sentence"]]


def test_the_board_goes_to_the_smallest_page_and_can_be_found_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "board.svg"
    code, out, _ = answer(capsys, "calibrate", "board", *ASKED, "--out", str(file))
    assert code == 0 and "on A3" in out and "For A4, 26 mm squares fit." in out
    assert 'width="420mm"' in file.read_text() and file.read_text().count('width="30.000"') == 35
    code, out, _ = answer(capsys, "calibrate", "board", "--board", "9x6", "--square", "0.025", "--json")
    told = json.loads(out)
    assert (told["page"], told["board"], told["files"]) == ("A4", "9x6", {})
    assert find_board(drawn(told["svg"]), Board(columns=9, rows=6, square=0.025)) is not None
    assert answer(capsys, "calibrate", "board", "--board", "9x6", "--square", "0.025")[1].startswith("<svg")


def drawn(svg: str) -> np.ndarray:
    """The squares of a page at 4 pixels a millimetre."""
    grey = np.full((840, 1188), 255, np.uint8)
    for line in svg.splitlines():
        if line.startswith("<rect x="):
            x, y, width, height = (round(4 * float(part.split('"')[0])) for part in line.split('="')[1:5])
            grey[y : y + height, x : x + width] = 20
    return grey


def test_an_input_that_cannot_be_used_is_told_in_json_with_its_code(
    pictures: list[str], camera: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    fisheye, nan = tmp_path / "fisheye.json", tmp_path / "nan.json"
    entry = json.loads(Path(camera).read_text())
    fisheye.write_text(json.dumps({**entry, "dist_model": "equidistant"}))
    nan.write_text(json.dumps({**entry, "image_size": "large"}))
    text = tmp_path / "text.png"
    text.write_text("no picture")
    straight = ("--out", str(tmp_path / "out"), "--json")
    for asked, code, sensor in (
        (("correct", *pictures, "--camera", str(fisheye), *straight), "camera.other_model", "fisheye.json"),
        (("correct", *pictures, "--camera", str(nan), *straight), "camera.malformed", "nan.json"),
        (("correct", str(text), "--camera", camera, *straight), "picture.unreadable", "text.png"),
        (("calibrate", "camera", str(text), *ASKED, "--json"), "picture.unreadable", "text.png"),
        (
            ("calibrate", "camera", *pictures[:2], "--board", "8x6", "--square", "0.03", "--json"),
            "board.use_other",
            "",
        ),
    ):
        exit_code, out, err = answer(capsys, *asked)
        told = json.loads(out)
        assert exit_code == 1 and err.endswith(f"beckon: {told['error']}\n")
        assert (told["faults"][0]["code"], told["faults"][0]["sensor"]) == (code, sensor)
    exit_code, out, _ = answer(capsys, "calibrate", "camera", str(text), *pictures[:4], *ASKED, "--json")
    assert exit_code == 0 and [each["code"] for each in json.loads(out)["faults"]] == ["picture.unreadable"]
