"""The thirteen pictures of OpenCV's left camera: what a good calibrator finds, and what bad corners may not spoil."""

import re
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from core.calibration.board.board import Board
from core.calibration.board.chessboard import FLAGS, SUBPIXEL_CRITERIA, search
from core.calibration.camera.intrinsics import Calibration, ViewCorners, calibrate
from core.calibration.files.camera_files import read_camera
from core.calibration.files.pictures import read_grey
from core.errors import BadInput
from core.message import Array
from core.pipelines.calibrate import calibrate_camera
from tests.real_data.poison import FAULTS, noisy, swapped

pytestmark = pytest.mark.real_data
BOARD = Board(columns=9, rows=6, square=0.025)
SIZE = (640, 480)


@pytest.fixture(scope="module")
def pictures(shared_data: Path) -> list[Path]:
    return sorted((shared_data / "chessboard-opencv-left").glob("left*.jpg"))


def corners_of(pictures: list[Path], window: int) -> list[ViewCorners]:
    views: list[ViewCorners] = []
    for path in pictures:
        grey, _ = read_grey(path)
        found = search(grey, BOARD, FLAGS)
        assert found is not None
        start = np.ascontiguousarray(found.reshape(-1, 1, 2), dtype=np.float32)
        refined = cv2.cornerSubPix(grey, start, (window, window), (-1, -1), SUBPIXEL_CRITERIA)
        views.append(ViewCorners(name=path.name, corners=refined.reshape(-1, 2).astype(float)))
    return views


@pytest.mark.parametrize(
    ("code", "of_other"), [("camera.two_settings", (-1.0, 639.0, 0.0)), ("camera.middle_varies", (1.0, 25.0, -18.0))]
)
def test_half_of_the_pictures_mirrored_or_cut_otherwise_are_named_so(
    views: list[ViewCorners], code: str, of_other: tuple[float, float, float]
) -> None:
    """The motion of a rolling shutter explains their errors as well, and was blamed."""
    across, right, down = of_other
    some = [
        ViewCorners(name=view.name, corners=view.corners * [across, 1.0] + [right, down]) if number % 2 else view
        for number, view in enumerate(views)
    ]
    assert code in [one.code for one in calibrate(some, BOARD, SIZE).faults]


def opencv_focal(views: list[ViewCorners]) -> float:
    shown = [BOARD.points.astype(np.float32)] * len(views)
    told = [view.corners.astype(np.float32) for view in views]
    return float(cv2.calibrateCamera(shown, told, SIZE, None, None, flags=cv2.CALIB_FIX_K3)[1][0, 0])


def test_the_camera_is_found_as_good_calibrators_find_it(pictures: list[Path]) -> None:
    told = calibrate_camera(pictures, BOARD)
    assert told["views_used"] == 13 and told["views_refused"] == []
    assert abs(told["fx"] - 533.1) < 1 and abs(told["fy"] - 533.1) < 1
    assert abs(told["cx"] - 342.5) < 1 and abs(told["cy"] - 233.9) < 1
    assert told["rms_px"] <= 0.21 and "k3" not in told
    assert 0.35 <= told["sd"]["fx"] <= 0.5
    assert told["correction"]["table_1"]["max_px"] < 0.42 and told["correction"]["exact"]["max_px"] < 1e-3


@pytest.fixture(scope="module")
def clean(views: list[ViewCorners]) -> Calibration:
    return calibrate(views, BOARD, SIZE)


def test_corners_that_a_large_window_pulled_away_do_not_spoil_it(pictures: list[Path]) -> None:
    views = corners_of(pictures, 11)
    told = calibrate(views, BOARD, SIZE)
    assert abs(told.model.fx - 533.1) < 1.5
    assert next(verdict for verdict in told.verdicts if verdict.name == "left02.jpg").reason
    assert opencv_focal(views) > 535.5


@pytest.fixture(scope="module")
def views(pictures: list[Path]) -> list[ViewCorners]:
    return corners_of(pictures, 5)


@pytest.mark.parametrize(
    "culprits", [range(1, 13, 11), pytest.param(range(13), marks=pytest.mark.campaign)], ids=["two", "all"]
)
@pytest.mark.parametrize("fault", FAULTS)
def test_each_view_in_turn_may_be_poisoned(
    views: list[ViewCorners], clean: Calibration, fault: Callable[[Array], Array], culprits: range
) -> None:
    for culprit in culprits:
        poisoned = list(views)
        poisoned[culprit] = ViewCorners(name=views[culprit].name, corners=fault(views[culprit].corners))
        told = calibrate(poisoned, BOARD, SIZE)
        assert told.verdicts[culprit].reason, f"{views[culprit].name} was not named"
        assert abs(told.model.fx - clean.model.fx) < 1.5 and abs(told.model.fy - clean.model.fy) < 1.5


def test_no_view_decides_alone_and_one_that_is_left_out_says_what_it_would_change(
    views: list[ViewCorners], clean: Calibration
) -> None:
    assert clean.deciding == "" and clean.warnings == ()
    for fault in (noisy, swapped):
        told = calibrate(
            [*views[:3], ViewCorners(name="bad", corners=fault(views[3].corners)), *views[4:]], BOARD, SIZE
        )
        assert not told.verdicts[3].used
        assert re.search(r"with it f would be 5\d\d\.\d instead of 533\.\d px, \d+ sd", told.verdicts[3].reason)
        assert ("to decide" in told.verdicts[3].reason) == (fault is noisy)


def test_k3_is_not_taken(clean: Calibration) -> None:
    assert clean.free[-1] == "p2" and clean.model.k3 == 0


def test_the_published_file_is_read_to_the_digit(shared_data: Path) -> None:
    model = read_camera(shared_data / "chessboard-opencv-left" / "left_intrinsics.yml")
    assert model.fx == 5.3591573396163199e02 and model.cy == 2.3557082909788173e02
    assert model.k1 == -2.6637260909660682e-01 and model.k3 == 2.3839153080878486e-01


@pytest.mark.parametrize("name", ["calib_missing_keys.json", "calib_nan.json", "alias_bomb.yaml"])
def test_malformed_cameras_are_refused_in_words(shared_data: Path, name: str) -> None:
    with pytest.raises(BadInput, match=name):
        read_camera(shared_data / "malformed" / name)


def test_malformed_pictures_are_refused_and_good_ones_read(shared_data: Path) -> None:
    pictures = [path for path in (shared_data / "malformed").iterdir() if path.suffix in (".jpg", ".png")]
    assert {path.name.startswith("ok_") for path in pictures} == {True, False}
    for path in pictures:
        if path.name.startswith("ok_"):
            assert read_grey(path)[0].shape == (120, 160)
        else:
            with pytest.raises(BadInput):
                read_grey(path)
