"""One bad view among thirteen: `python -m tests.benchmarks.calibration_poison FOLDER`.

FOLDER holds the pictures of OpenCV's left camera. Each view in turn is replaced by wrong corners, in every way of
tests/real_data/poison.py; OpenCV's plain solve stands beside. The same with corners that a sub-pixel window of 11
pixels pulled away.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from core.calibration.board.board import Board
from core.calibration.board.chessboard import FLAGS, SUBPIXEL_CRITERIA, search
from core.calibration.camera.intrinsics import ViewCorners, calibrate
from core.calibration.files.pictures import read_grey
from core.message import Array
from tests.benchmarks.command import run_command
from tests.real_data.poison import FAULTS

BOARD = Board(columns=9, rows=6, square=0.025)
SIZE = (640, 480)


def corners_of(path: Path, window: int) -> ViewCorners:
    grey, _ = read_grey(path)
    found = search(grey, BOARD, FLAGS)
    assert found is not None
    start = np.ascontiguousarray(found.reshape(-1, 1, 2), dtype=np.float32)
    refined = cv2.cornerSubPix(grey, start, (window, window), (-1, -1), SUBPIXEL_CRITERIA)
    return ViewCorners(name=path.name, corners=refined.reshape(-1, 2).astype(float))


def opencv_focal(views: list[ViewCorners]) -> float:
    shown = [BOARD.points.astype(np.float32)] * len(views)
    told = [view.corners.astype(np.float32) for view in views]
    return float(cv2.calibrateCamera(shown, told, SIZE, None, None, flags=cv2.CALIB_FIX_K3)[1][0, 0])


def poisoned(views: list[ViewCorners], fault: Callable[[Array], Array]) -> dict[str, Any]:
    """Each view in turn → how often it was named, and how far f moved, ours and OpenCV's."""
    clean, plain = calibrate(views, BOARD, SIZE).model, opencv_focal(views)
    named, ours, theirs = 0, [], []
    for culprit, view in enumerate(views):
        spoilt = [*views[:culprit], ViewCorners(name=view.name, corners=fault(view.corners)), *views[culprit + 1 :]]
        told = calibrate(spoilt, BOARD, SIZE)
        named += bool(told.verdicts[culprit].reason)
        ours.append(max(abs(told.model.fx - clean.fx), abs(told.model.fy - clean.fy)))
        theirs.append(abs(opencv_focal(spoilt) - plain))
    return {
        "fault": fault.__name__,
        "named": f"{named} of {len(views)}",
        "f_moves_most_px": max(ours),
        "opencv_f_moves_most_px": max(theirs),
    }


def main(folder: Path) -> object:
    pictures = sorted(folder.glob("left*.jpg"))
    views = {window: [corners_of(path, window) for path in pictures] for window in (5, 11)}
    wide = calibrate(views[11], BOARD, SIZE)
    return {
        "poison": [poisoned(views[5], fault) for fault in FAULTS],
        "window_11": {
            "fx": wide.model.fx,
            "fy": wide.model.fy,
            "rms_px": wide.rms,
            "remarks": {verdict.name: verdict.reason for verdict in wide.verdicts if verdict.reason},
            "opencv_fx": opencv_focal(views[11]),
        },
    }


if __name__ == "__main__":
    run_command(main)
