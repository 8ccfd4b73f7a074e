"""Models of the user's own: every layout finds who is in its file, and everything else is refused in a sentence."""

import math
import time
from pathlib import Path

import numpy as np
import pytest

from core.errors import BadInput
from core.message import Array
from core.perception.people.engines import open_detector
from core.perception.people.looking import LookQuestion
from core.perception.people.onnx.detector import input_shape, open_own_model
from core.perception.people.parts import PeopleSettings
from core.perception.people.pose.faces import anchors
from tests.core.perception.onnx_files import greedy_file, onnx_file
from tests.core.perception.stick_figures import STANCE
from tests.core.perception.test_pose import PHOTO

SIDE = 320  # [pixel] of the input; the picture is 640 x 480, so that it is halved
CENTRE, TOP, TALL, WIDE = 200.0, 40.0, 180.0, 60.0  # [pixel of the input] of someone
BOX = (CENTRE - WIDE / 2, TOP, CENTRE + WIDE / 2, TOP + TALL)
MIDDLE = (CENTRE, TOP + TALL / 2, WIDE, TALL)
ROWS = [0, 2, 5, 7, 8, 11, 12, 13, 14, 15, 16, 23, 24, 25, 26, 27, 28]  # of the 33 landmarks: COCO's 17
POINTS = np.column_stack((np.array([CENTRE, TOP]) + TALL * STANCE[ROWS], np.full(17, 0.95)))


def yolo(numbers: int, places: int = 300) -> Array:
    rows = np.zeros((numbers, places))
    rows[:4, 7], rows[4, 7] = MIDDLE, 0.9
    rows[:4, 9], rows[4, 9] = np.add(MIDDLE, (2, 2, 0, 0)), 0.8  # the same once more
    if numbers == 56:
        rows[5:, 7] = POINTS.ravel()
    return rows[None]


def sorted_out(numbers: int) -> Array:
    rows = np.zeros((300, numbers))
    rows[0, :6] = (*BOX, 0.9, 0)
    rows[1, :6] = (10, 10, 80, 200, 0.9, 16)  # a dog
    if numbers == 57:
        rows[0, 6:] = POINTS.ravel()
    return rows[None]


def yolox() -> Array:
    places = sum((SIDE // stride) ** 2 for stride in (8, 16, 32))
    rows = np.zeros((places, 85))
    column, row = 25, 16  # of stride 8
    rows[row * 40 + column, :6] = (
        CENTRE / 8 - column,
        (TOP + TALL / 2) / 8 - row,
        *np.log(np.array([WIDE, TALL]) / 8),
        0.95,
        0.95,
    )
    return rows[None]


def rtmo() -> list[Array]:
    boxes, points = np.zeros((20, 5)), np.zeros((20, 17, 3))
    boxes[3], points[3] = (*BOX, 0.9), POINTS
    return [boxes[None], points[None]]


def faces() -> list[Array]:
    rows, scores = np.zeros((2254, 12)), np.full((2254, 1), -50.0)
    place, at = anchors()[900], 900
    hips, rim = (CENTRE, TOP + 0.47 * TALL), (CENTRE, TOP - 0.03 * TALL)
    scale = 224 / SIDE
    rows[at, 4:8] = (np.array([*hips, *rim]) * scale / 224 - np.tile(place, 2)) * 224
    scores[at] = 4.0
    return [rows[None], scores[None]]


LAYOUTS = {
    "YOLO": (SIDE, [yolo(84)]),
    "YOLO of one class": (SIDE, [yolo(5)]),
    "YOLO pose": (SIDE, [yolo(56)]),
    "YOLO without doubles": (SIDE, [sorted_out(6)]),
    "YOLO pose without doubles": (SIDE, [sorted_out(57)]),
    "YOLOX": (SIDE, [yolox()]),
    "RTMO": (SIDE, rtmo()),
    "MediaPipe's person detector": (224, faces()),
}


@pytest.fixture(params=LAYOUTS)
def model(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    side, answers = LAYOUTS[request.param]
    path = tmp_path / "model.onnx"
    path.write_bytes(onnx_file((1, 3, side, side), answers))
    return path


def test_who_is_in_the_file_is_found_in_its_direction(model: Path) -> None:
    detector = open_own_model(model, PeopleSettings())
    picture = np.full((480, 640, 3), 128, np.uint8)
    (found,) = detector.look(LookQuestion(pixels=picture, camera=PHOTO, on_floor=False))
    left, _, right, bottom = found.box
    assert left < 2 * CENTRE < right and bottom > 2 * (TOP + 0.8 * TALL)
    assert [part.likelihood for part in found.parts] == pytest.approx([0.9, 0.9, 0.9], abs=0.09)
    aside = -math.atan((2 * CENTRE - 319.5) / 550)
    assert found.bearing == pytest.approx(aside, abs=0.02)
    towards = LookQuestion(pixels=picture, camera=PHOTO, bearing=aside, distances=(550 * 1.7 / 360,), on_floor=False)
    assert len(detector.look(towards)) == 1
    away = LookQuestion(pixels=picture, camera=PHOTO, bearing=aside + 0.4, on_floor=False)
    assert detector.look(away) == ()


def test_mediapipes_landmark_file_is_used_as_the_pose_networks_are(tmp_path: Path) -> None:
    rows = np.zeros((39, 5))
    rows[:33, :2], rows[:, 3:] = (128, 10) + 230 * STANCE, 8.0
    answers = [rows.reshape(1, 195), np.array([[0.97]]), np.zeros((1, 117))]
    (tmp_path / "pose.onnx").write_bytes(onnx_file((1, 256, 256, 3), answers))
    detector = open_detector(PeopleSettings(model=str(tmp_path / "pose.onnx")))
    assert detector.name == "pose" and "your own file" in detector.says
    question = LookQuestion(pixels=np.zeros((480, 640, 3), np.uint8), camera=PHOTO, bearing=0.0, on_floor=False)
    assert detector.look(question)


def test_the_size_of_the_picture_is_read_from_the_file() -> None:
    assert input_shape(onnx_file((1, 3, 416, 416), [np.zeros((1, 2))])) == (1, 3, 416, 416)
    assert input_shape(onnx_file((1, 3, 0, 0), [np.zeros((1, 2))])) == (1, 3, 640, 640)  # left open
    assert input_shape(onnx_file((1, 256, 256, 3), [np.zeros((1, 2))])) == (1, 256, 256, 3)


GOOD = onnx_file((1, 3, 320, 320), [yolo(84)])


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "no ONNX file"),
        (b"\x00" * 1000, "no ONNX file"),
        (b"\xff" * 1000, "no ONNX file"),
        (GOOD[: len(GOOD) // 2], "no ONNX file"),
        (onnx_file((1, 3, 320, 320), [np.zeros((1, 7, 9))]), "1x7x9, which are none of those known"),
        (onnx_file((1, 4, 320, 320), [yolo(84)]), "colour picture"),
        (onnx_file((1, 3, 100_000, 100_000), [yolo(84)]), "colour picture"),
        (GOOD.replace(b"GlobalAveragePool", b"GlobalAveragePoop"), "OpenCV cannot"),
        (greedy_file(1920, 400), "OpenCV cannot run it"),  # 6 GB in the picture's size
    ],
)
def test_files_that_are_no_known_model_get_a_sentence_soon(tmp_path: Path, content: bytes, words: str) -> None:
    path = tmp_path / "bad.onnx"
    path.write_bytes(content)
    began = time.process_time()
    with pytest.raises(BadInput, match=words):
        open_own_model(path, PeopleSettings())
    assert time.process_time() - began < 2.0
    with pytest.raises(BadInput, match="no such file"):
        open_own_model(tmp_path / "absent.onnx", PeopleSettings())


def test_numbers_that_are_none_find_nobody(tmp_path: Path) -> None:
    broken = yolo(84)
    broken[0, :, 7] = np.nan
    broken[0, :4, 9] = np.inf
    (tmp_path / "nan.onnx").write_bytes(onnx_file((1, 3, 320, 320), [broken]))
    detector = open_own_model(tmp_path / "nan.onnx", PeopleSettings())
    assert detector.look(LookQuestion(pixels=np.zeros((480, 640, 3), np.uint8), camera=PHOTO, on_floor=False)) == ()
