"""`beckon look`: people in picture files, questions from a file, and a sentence for every bad one."""

import json
import time
from pathlib import Path

import cv2
import numpy as np
import pytest

from console.__main__ import main
from core.calibration.files.camera_files import ros_yaml
from core.errors import BadInput
from core.optics import CameraModel
from core.perception.people.pose.detector import PoseDetector
from core.pipelines import look as pipeline
from tests.core.perception.stick_figures import StickNetworks, white_body
from tests.core.recording.log_writers import ROS2, TF, Types, write_mcap


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Two pictures, one with someone in it, and a detector for white figures."""
    monkeypatch.setattr(pipeline, "open_detector", lambda settings: PoseDetector(StickNetworks(), settings))
    cv2.imwrite(str(tmp_path / "one.png"), white_body(640, 480, 420.0, 80.0, 300.0))
    cv2.imwrite(str(tmp_path / "none.png"), white_body(640, 480, 0.0, 0.0, 0.0))
    return tmp_path


def answer(capsys: pytest.CaptureFixture[str], *words: object, code: int = 0) -> dict:
    assert main(["look", *map(str, words), "--json"]) == code
    return json.loads(capsys.readouterr().out)


def test_someone_in_a_direction_is_answered_with_parts_and_k(folder, capsys) -> None:
    told = answer(capsys, folder / "one.png", "--azimuth", -0.17, "--distance", 3.3, "--fov", 1.05)
    assert set(told) >= {"people", "processing_s", "engine"} and told["engine"] == "pose"
    (one,) = told["people"]
    assert set(one) >= {"box", "head", "torso", "feet", "k1", "k2", "k3", "k", "azimuth_rad", "azimuth_sd_rad"}
    assert one["azimuth_rad"] == pytest.approx(-0.18, abs=0.02)
    left, top, right, bottom = one["box"]
    assert left < 420 < right and abs(top - 80) < 30 and abs(bottom - 380) < 30
    assert answer(capsys, folder / "one.png", "--azimuth", 0.3, "--distance", 3.3)["people"] == []
    assert len(answer(capsys, folder / "one.png")["people"]) == 1
    assert answer(capsys, folder / "none.png")["people"] == []


@pytest.mark.parametrize(
    ("shades", "said"), [((2, 20), "nearly black"), ((120, 130), "nearly of one shade"), ((40, 70), "")]
)
def test_a_picture_in_which_nobody_could_be_seen_is_told(tmp_path, capsys, shades, said) -> None:
    drawn = np.random.default_rng(3).integers(*shades, (240, 320, 1)).repeat(3, axis=2)
    cv2.imwrite(str(tmp_path / "night.png"), drawn)
    found = answer(capsys, tmp_path / "night.png")
    assert found["people"] == [] and said in found.get("remark", "") and ("remark" in found) == bool(said)


def test_many_questions_are_answered_in_their_order(folder, capsys) -> None:
    rows = [
        {"picture": "one.png", "azimuth_rad": -0.17, "distance_m": 3.3, "fov_rad": 1.05},
        {"picture": "none.png", "azimuth_rad": 0.0, "distance_m": None, "fov_rad": 1.05},
        {"picture": "absent.png", "azimuth_rad": 0.0},
        {"picture": "one.png", "azimuth_rad": -0.17, "distance_m": None, "fov_rad": 1.05},
    ]
    (folder / "ask.json").write_text(json.dumps(rows))
    told = answer(capsys, "--ask", folder / "ask.json", "--draw", folder / "drawn")
    assert [len(one["people"]) for one in told["answers"]] == [1, 0, 0, 1]
    assert "no such file" in told["answers"][2]["error"]
    assert len(list((folder / "drawn").glob("*.jpg"))) == 3


def test_a_recording_is_looked_at_as_often_as_was_asked(folder, capsys) -> None:
    kind = Types(ROS2)
    name = "sensor_msgs/msg/CompressedImage"

    def sent(stamp: float, file: str) -> tuple:
        data = np.frombuffer((folder / file).read_bytes(), np.uint8)
        return "/camera", name, stamp, kind.types[name](header=kind.header(stamp, "camera"), format="png", data=data)

    write_mcap(folder / "walk.mcap", [sent(100 + 0.5 * n, "one.png" if n < 3 else "none.png") for n in range(6)])
    told = answer(capsys, folder / "walk.mcap", "--fov", 1.05)
    assert [(one["t_s"], len(one["people"])) for one in told["answers"]] == [(0.0, 1), (1.0, 1), (2.0, 0)]
    every = answer(capsys, folder / "walk.mcap", "--every", 0, "--draw", folder / "drawn")
    assert len(every["answers"]) == 6 == len(list((folder / "drawn").glob("*.jpg")))
    alone = answer(capsys, folder / "one.png", "--fov", 1.05)
    assert told["answers"][0]["people"] == alone["people"]
    write_mcap(folder / "blind.mcap", [("/tf", TF, 1.0, kind.tf(1.0, "a", "b", (0, 0, 0)))])
    assert "holds no pictures" in answer(capsys, folder / "blind.mcap", code=1)["error"]


def test_large_pictures_are_shrunk_and_boxes_grow_back(folder, capsys) -> None:
    cv2.imwrite(str(folder / "large.png"), cv2.resize(cv2.imread(str(folder / "one.png")), None, fx=5, fy=5))
    small, large = (answer(capsys, folder / name)["people"][0] for name in ("one.png", "large.png"))
    assert np.array(large["box"]) / 5 == pytest.approx(np.array(small["box"]), abs=4)
    assert large["azimuth_rad"] == pytest.approx(small["azimuth_rad"], abs=0.005)


def test_an_improbable_calibration_is_said_once_and_stands_in_each_answer(folder, capsys) -> None:
    model = CameraModel(width=640, height=480, fx=520.0, fy=260.0, cx=322.0, cy=236.0)
    (folder / "wide.yaml").write_text(ros_yaml(model))
    words = ["look", str(folder / "one.png"), str(folder / "none.png"), "--camera", str(folder / "wide.yaml")]
    assert main([*words, "--json"]) == 0
    said = capsys.readouterr()
    answers = json.loads(said.out)["answers"]
    assert [one["faults"][0]["code"] for one in answers] == ["camera.focal_ratio"] * 2
    assert said.err.count("The calibration of wide.yaml has fx = 520 and fy = 260") == 1


def test_a_calibration_of_another_camera_is_refused(folder, capsys) -> None:
    camera = {
        "width": 640,
        "height": 400,
        "fx": 500.0,
        "fy": 500.0,
        "cx": 320.0,
        "cy": 200.0,
        "k1": 0,
        "k2": 0,
        "p1": 0,
        "p2": 0,
    }
    (folder / "camera.json").write_text(json.dumps({"camera": camera}))
    assert main(["look", str(folder / "one.png"), "--camera", str(folder / "camera.json")]) == 1
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "no JPEG"),
        (b"\x89PNG\r\n\x1a\n" + b"\0" * 50, "no JPEG"),
        (b"\xff\xd8\xff\xe0\x00\x10JFIF" + b"\0" * 100, "no JPEG"),
        (b"BM" + b"\xff" * 100, "pixels"),
        (b"P6 100000 100000 255\n", "Mpx"),
    ],
)
def test_bad_pictures_get_a_sentence_soon(folder, capsys, content: bytes, words: str) -> None:
    (folder / "bad.jpg").write_bytes(content)
    began = time.process_time()
    assert main(["look", str(folder / "bad.jpg")]) == 1
    told = capsys.readouterr().err
    assert words in told and "Traceback" not in told
    assert time.process_time() - began < 2.0


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{}", "no list"),
        ("[1]", "no list"),
        ('[{"azimuth_rad": 1}]', "picture"),
        ("[" * 5000, "no list"),
        ("\xff", "is not a text file"),
    ],
)
def test_a_bad_file_of_questions_is_named(folder, capsys, text: str, words: str) -> None:
    (folder / "ask.json").write_text(text, encoding="latin-1")
    assert main(["look", "--ask", str(folder / "ask.json")]) == 1
    assert words in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "code"),
    [
        ([], 2),
        (["--azimuth", "9"], 1),
        (["--distance", "2"], 1),
        (["--azimuth", "0", "--distance", "0"], 1),
        (["--azimuth", "nan"], 1),
        (["--fov", "7"], 1),
    ],
)
def test_numbers_that_mean_nothing_are_refused(folder, capsys, words: list[str], code: int) -> None:
    assert main(["look", *([str(folder / "one.png")] if words else []), *words]) == code
    assert "Traceback" not in capsys.readouterr().err


def test_people_are_told_in_words(folder, capsys) -> None:
    assert main(["look", str(folder / "one.png"), str(folder / "none.png")]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "to the right" in lines[0] and "K 0." in lines[0]
    assert lines[1] == "none.png: I see nobody there."


def test_each_picture_is_told_when_it_was_looked_at_and_an_interrupted_batch_keeps_what_was_done(
    folder, capsys, monkeypatch: pytest.MonkeyPatch
) -> None:
    printed: list[str] = []
    answered = pipeline._answered

    def interrupted(*given: object) -> pipeline.LookedPicture:
        printed.append(capsys.readouterr().out)
        if len(printed) == 2:
            raise KeyboardInterrupt
        return answered(*given)

    monkeypatch.setattr(pipeline, "_answered", interrupted)
    files = [str(folder / name) for name in ("one.png", "none.png")]
    assert main(["look", *files, "--json"]) == 130
    told = json.loads("".join((*printed, capsys.readouterr().out)))
    assert [one["picture"] for one in told["answers"]] == list(told["files"]) == ["one.png"]
    assert told["engine"] == "pose"
    printed.clear()
    assert main(["look", *files]) == 130 and printed[1].startswith("one.png: someone")


@pytest.mark.parametrize(
    ("key", "own"),
    [
        ("azimuth_deg", "azimuth_rad"),
        ("azimuth", "azimuth_rad"),
        ("Azimuth_Rad", "azimuth_rad"),
        ("azimuth_sd_deg", "azimuth_sd_rad"),
        ("distance_mm", "distance_m"),
        ("fov_deg", "fov_rad"),
        ("fov", "fov_rad"),
        ("truth", None),
        ("picture_id", None),
    ],
)
def test_a_question_in_another_unit_is_refused_and_not_answered_without_it(
    key: str, own: str | None, tmp_path: Path
) -> None:
    file = tmp_path / "ask.json"
    file.write_text(json.dumps([{"picture": "a.jpg"}, {"picture": "b.jpg", key: 1}]))
    if own is None:
        assert len(pipeline.read_questions(file)) == 2
        return
    with pytest.raises(BadInput, match=rf"ask\.json says {key}, which is not read; write {own}\."):
        pipeline.read_questions(file)
