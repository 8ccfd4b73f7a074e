"""What a browser's camera sees in a test: a practice board, shown in several poses, as a film that begins anew."""

from pathlib import Path

import numpy as np

from core.calibration.board.board import Board
from core.calibration.practice import BoardPlacement, ImageExposure, held, picture
from core.calibration.projection import Poses
from core.message import Array
from core.optics import CameraModel

BOARD = Board(columns=9, rows=6, square=0.03)
CAMERA = CameraModel(width=320, height=240, fx=300, fy=301, cx=158, cy=121, k1=-0.25, k2=0.08, p1=0.001, p2=-0.001)
HELD = BoardPlacement(nearest=0.33, farthest=0.55, least_tilt=np.deg2rad(15), margin=14)
RATE = 5  # [Hz]
STILL = 8  # pictures of every pose
VIEWS = 8
SHAKEN = 11.0  # [pixel] of motion in the pose that has to be refused


def poses() -> Poses:
    """As a person would hold it; the same ones every time."""
    return held(np.random.default_rng(3), VIEWS, CAMERA, BOARD, HELD)


def pictures() -> list[Array]:
    """Grey pictures (240, 320): a shaken one first, then one of every pose."""
    rng = np.random.default_rng(3)
    shown = poses()
    perturbed = picture(rng, CAMERA, shown.take(slice(0, 1)), BOARD, ImageExposure(motion=SHAKEN))
    return [perturbed, *(picture(rng, CAMERA, shown.take(slice(k, k + 1)), BOARD) for k in range(VIEWS))]


def film(path: Path) -> Path:
    """Write the pictures as YUV4MPEG2, which Chromium plays as a camera, over and over."""
    chroma = np.full(CAMERA.width * CAMERA.height // 2, 128, np.uint8).tobytes()
    with path.open("wb") as out:
        out.write(f"YUV4MPEG2 W{CAMERA.width} H{CAMERA.height} F{RATE}:1 Ip A1:1 C420jpeg\n".encode())
        for grey in pictures():
            out.write((b"FRAME\n" + grey.tobytes() + chroma) * STILL)
    return path
