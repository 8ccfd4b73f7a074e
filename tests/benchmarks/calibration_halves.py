"""Cameras from halves of the same pictures: `python -m tests.benchmarks.calibration_halves 9x6 PICTURE … --draws 6`.

Two cameras from random halves of a set may differ by what is stated of them. Printed is the root mean square of their
difference in focal length and principal point over the deviations that are stated, of Beckon as they are, of Beckon
times its `disagreement`, and of OpenCV on the same corners. Halves that Beckon refuses to decide are left out and
counted. Public sets to try: the repositories stereo-calibration (sourishg), CarND-Camera-Calibration and
CarND-Advanced-Lane-Lines (udacity), camera_calibration (ksonod, sandokim), PRJ_Camera_Calibration (JuMpYggdrasil),
Camera_Calibration (Yosshu), Chessboard_Based_Camera_Calibration (prozyr), and OpenCV's left pictures.
"""

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from core.calibration.board.board import Board
from core.calibration.board.chessboard import find_board
from core.calibration.board.quality import judge
from core.calibration.camera.intrinsics import Calibration, ViewCorners, calibrate
from core.calibration.files.pictures import read_grey
from core.message import Array
from tests.benchmarks.command import run_command

COMPARED_PARAMETERS = ("fx", "cx", "cy")
SQUARE_M = 0.03  # a camera does not depend on it


def corners_of(pictures: Sequence[Path], board: Board) -> tuple[list[ViewCorners], tuple[int, int]]:
    """The corners of pictures of one size that can be used, and that size [pixel]."""
    views: list[ViewCorners] = []
    height, width = 0, 0
    for path in pictures:
        grey, _ = read_grey(path)
        height, width = (height, width) if views else grey.shape
        seen = find_board(grey, board) if grey.shape == (height, width) else None
        if seen is not None and not judge(grey, seen, board).refusals:
            views.append(ViewCorners(name=path.name, corners=seen.corners))
    return views, (width, height)


def of_opencv(views: Sequence[ViewCorners], board: Board, size: tuple[int, int]) -> tuple[Array, Array]:
    """COMPARED_PARAMETERS of OpenCV's camera and its deviations."""
    shown = [board.points.astype(np.float32)] * len(views)
    corners = [view.corners.astype(np.float32) for view in views]
    _, matrix, _, _, _, sds, _, _ = cv2.calibrateCameraExtended(
        shown, corners, size, None, None, flags=cv2.CALIB_FIX_K3
    )
    return np.array([matrix[0, 0], matrix[0, 2], matrix[1, 2]]), sds.ravel()[[0, 2, 3]]


def apart(one: Calibration, other: Calibration, *, counted: bool) -> Array:
    """The difference of COMPARED_PARAMETERS over the stated deviations, `counted` with what is said of them."""
    (here, sds), (there, other_sds) = (
        np.array([(getattr(each.model, name), each.sds[name]) for name in COMPARED_PARAMETERS]).T
        * np.array([[1.0], [each.disagreement if counted else 1.0]])
        for each in (one, other)
    )
    return (here - there) / np.hypot(sds, other_sds)


def main(board: str, pictures: Sequence[Path], *, draws: int = 6, seed: int = 0) -> object:
    columns, rows = map(int, board.split("x"))
    shown = Board(columns=columns, rows=rows, square=SQUARE_M)
    views, size = corners_of(sorted(pictures), shown)
    rng, undecided = np.random.default_rng(seed), 0
    found: dict[str, list[Array]] = {"stated": [], "with_disagreement": [], "opencv": []}
    for _ in range(draws):
        order = rng.permutation(len(views))
        halves = [[views[number] for number in sorted(half)] for half in np.array_split(order, 2)]
        one, other = (calibrate(half, shown, size) for half in halves)
        (theirs, sds), (others, other_sds) = (of_opencv(half, shown, size) for half in halves)
        found["opencv"].append((theirs - others) / np.hypot(sds, other_sds))
        if one.undecided or other.undecided:
            undecided += 1
            continue
        found["stated"].append(apart(one, other, counted=False))
        found["with_disagreement"].append(apart(one, other, counted=True))
    whole = calibrate(views, shown, size)
    return {
        "pictures": len(views),
        "fx": round(whole.model.fx, 1),
        "sd_fx": round(whole.sds["fx"], 2),
        "disagreement": round(whole.disagreement, 2),
        "said": [each.code for each in whole.faults],
        "draws": draws,
        "undecided": undecided,
    } | {
        name: dict(zip(COMPARED_PARAMETERS, np.sqrt(np.mean(np.square(each), axis=0)).round(1).tolist(), strict=True))
        for name, each in found.items()
        if each
    }


if __name__ == "__main__":
    run_command(main)
