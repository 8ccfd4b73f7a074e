"""The mount from one recording: the board is carried about and held still now and then, nobody picks pairs."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from console.__main__ import main
from core.calibration.files.camera_files import camera_entry
from core.calibration.practice import ImageExposure, picture
from core.calibration.projection import Poses
from core.geometry import Transform
from core.optics import TABLE_3
from core.pipelines.calibrate_from_recording import calibrate_camera_recorded, calibrate_laser_recorded
from core.progress import WorkProgress
from tests.core.calibration.rooms_to_practise import BOARD, a_room, error_of
from tests.core.recording.log_writers import ROS2, SCAN, Types, write_mcap
from tests.practice_room import PracticeRoom

KIND = Types(ROS2)
IMAGE, COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"


def raw(stamp: float, grey: np.ndarray) -> Any:
    colour = np.dstack((grey, grey, grey))
    height, width = grey.shape
    return KIND.types[IMAGE](
        header=KIND.header(stamp, "camera"),
        height=height,
        width=width,
        encoding="rgb8",
        is_bigendian=0,
        step=3 * width,
        data=colour.ravel(),
    )


def compressed(stamp: float, grey: np.ndarray) -> Any:
    data = cv2.imencode(".png", grey)[1].ravel()
    return KIND.types[COMPRESSED](header=KIND.header(stamp, "camera"), format="png", data=data)


def carried_about(room: PracticeRoom, packed: bool, poses: int = 12) -> Iterator[tuple[str, str, float, Any]]:
    """Topic, kind, time and message: an empty room, then every pose still for 0.6 s after a moving picture."""
    camera = ("/camera", COMPRESSED, compressed) if packed else ("/camera", IMAGE, raw)
    stamp, wall = 1000.0, np.full((TABLE_3.height, TABLE_3.width), 120, np.uint8)

    def at(grey: np.ndarray, ranges: np.ndarray) -> Iterator[tuple[str, str, float, Any]]:
        nonlocal stamp
        stamp += 0.1
        laser = room.laser
        scan = {"angle_min": laser.angle_min, "angle_increment": laser.angle_step}
        yield camera[0], camera[1], stamp, camera[2](stamp, grey)
        yield "/scan", SCAN, stamp + 0.02, KIND.scan(stamp + 0.02, ranges, **scan)

    for ranges in room.background(8):
        yield from at(wall, ranges)
    for shot in room.shots(poses, 6):
        pose = Poses(shot.rotation[None], shot.translation[None])
        yield from at(picture(room.rng, TABLE_3, pose, BOARD, ImageExposure(motion=12)), shot.scans[0])
        still = picture(room.rng, TABLE_3, pose, BOARD)
        for ranges in shot.scans:
            noise = room.rng.normal(0, 2, still.shape)
            yield from at(np.clip(still + noise, 0, 255).astype(np.uint8), ranges)


class SharesOfWork(WorkProgress):
    """Keeps what it is told."""

    def __init__(self) -> None:
        self.shares: list[float] = []

    def at(self, share: float, doing: str = "") -> None:
        self.shares.append(share)


@pytest.fixture
def camera(tmp_path: Path) -> Path:
    file = tmp_path / "camera.json"
    file.write_text(json.dumps(camera_entry(TABLE_3)))
    return file


@pytest.mark.parametrize("packed", [pytest.param(True, marks=pytest.mark.campaign), False])
def test_a_recording_becomes_a_mount(tmp_path: Path, camera: Path, packed: bool) -> None:
    room = a_room(6, noise=0.01)
    file = tmp_path / "carried.mcap"
    write_mcap(file, carried_about(room, packed))
    progress = SharesOfWork()
    told = calibrate_laser_recorded(file, camera, BOARD, tmp_path / "out", progress=progress)
    found = Transform(rotation=np.array(told["rotation"]), translation=np.array(told["translation_m"]))
    turn, shift = error_of(found, room)
    assert turn < 1 and shift < 8
    assert told["poses_used"] >= 7 and told["poses_used"] + len(told["poses_refused"]) <= 14
    assert Path(told["files"]["json"]).is_file()
    assert progress.shares == sorted(progress.shares) and progress.shares[-1] > 0.5
    assert not [each for each in told["warnings"] if "skipped" in each]
    if packed:
        seen = calibrate_camera_recorded(file, BOARD)
        assert seen["views_used"] >= 7 and seen["image_size"] == [TABLE_3.width, TABLE_3.height]
        assert abs(seen["fx"] - TABLE_3.fx) < 4 * seen["sd"]["fx"] + 1.0 and seen["rms_px"] < 0.5


def test_recordings_without_pictures_scans_or_board_are_told_in_a_sentence(
    tmp_path: Path, camera: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    every = list(carried_about(a_room(5), packed=True, poses=1))
    small = [("/camera", COMPRESSED, 1.0, compressed(1.0, np.zeros((480, 640), np.uint8))), *every[1:4:2]]
    broken = ("/camera", COMPRESSED, 1.0, compressed(1.0, np.zeros((2, 2), np.uint8)))
    recordings = {
        "holds no pictures.": every[1:16:2],
        "holds no laser scans.": every[:16:2],
        "shows a 9x6 board": every[:16],
        "640x480": small,
        "only 2x2": [broken, *every[1:4:2]],
        "at least 3 are needed": every,
    }
    for sentence, messages in recordings.items():
        file = tmp_path / "some.mcap"
        write_mcap(file, messages)
        asked = ["calibrate", "laser", str(file), "--camera", str(camera), "--board", "9x6", "--square", "0.03"]
        assert main([*asked, "--json"]) == 1
        said = capsys.readouterr()
        assert sentence in said.err.splitlines()[-1]
        assert not said.out or sentence in json.loads(said.out)["error"]
    for name in ("text.mcap", "text.bag", "text.db3"):
        (tmp_path / name).write_text("no recording")
        assert main(["calibrate", "laser", str(tmp_path / name), *asked[3:]]) == 1
        assert "went wrong" not in capsys.readouterr().err
