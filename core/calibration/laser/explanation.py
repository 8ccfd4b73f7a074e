"""Explain a mount's calibration to the person who has to decide."""

from typing import TypedDict

import numpy as np

from core.calibration.board.board import Board
from core.calibration.laser.solve import LaserCalibration
from core.calibration.mount import FEW_POSES, Extrinsics
from core.calibration.projection import Poses, cross_matrices, linearise, vector_of
from core.message import Array
from core.optics import CameraModel

LANDING_DISTANCES_M = (0.5, 1.0, 3.0)
MAX_MISFIT = 4.0  # misfit above which the sensors contradict each other by more than twice their noise
SURE_SDS, CLEAR_SHARE = 3.0, 0.01  # the laser contradicts the ruler by so many sds and by so large a share

TILT = "tilt the board forward and back by 20 to 50 degrees, and towards its corners"
ADVICE = {
    "roll": TILT,
    "pitch": TILT,
    "height": TILT,
    "yaw": "turn the board to the left and right by 20 to 50 degrees, and show it at both sides",
    "sideways": "turn the board to the left and right by 20 to 50 degrees",
    "forward": "show the board facing the sensors, near and far",
}
MEANING = {
    "roll": "roll (turn about the viewing direction)",
    "pitch": "pitch (looking up or down)",
    "yaw": "yaw (looking left or right)",
    "forward": "forward offset",
    "sideways": "sideways offset",
    "height": "height (up-down offset)",
}


class LaserLanding(TypedDict):
    """How far beside its place a laser point may be drawn, at one distance (95 %: two standard deviations)."""

    distance_m: float
    sideways_px: float
    up_down_px: float


def landings(found: Extrinsics, model: CameraModel) -> list[LaserLanding]:
    """The mount → how exactly laser points at 0.5, 1 and 3 m, where the camera looks, are placed in the picture."""
    sight = found.transform.rotation[:, 2] * (1.0, 1.0, 0.0)
    ahead = sight / np.linalg.norm(sight) if np.linalg.norm(sight) > 0.1 else np.array([1.0, 0.0, 0.0])
    return [_landing(found, model, ahead * distance) for distance in LANDING_DISTANCES_M]


def laser_offset_words(offsets: list[LaserLanding]) -> str:
    """One sentence."""
    sideways = " / ".join(f"{each['sideways_px']:.1f}" for each in offsets)
    up_down = " / ".join(f"{each['up_down_px']:.1f}" for each in offsets)
    distances = " / ".join(f"{each['distance_m']:g}" for each in offsets)
    return f"A laser point lands within ±{sideways} px sideways and ±{up_down} px up-down at {distances} m (95 %)."


def weak_words(found: Extrinsics) -> tuple[str, ...]:
    """A sentence for every direction that neither poses nor ruler determine; never a bare number."""
    return tuple(
        f"{MEANING[name]} is not known from these poses and stays near the nominal mount: {ADVICE[name]}."
        for name in found.unknown
    )


def warnings(calibration: LaserCalibration, board: Board) -> tuple[str, ...]:
    """Reasons to doubt the calibration."""
    sentences = [calibration.doubt] if calibration.doubt else []
    found = calibration.extrinsics
    used = int(np.count_nonzero(calibration.used))
    if used < FEW_POSES:
        sentences.append(f"Only {used} poses were used; the stated uncertainty is doubled. Show 10 or more.")
    doubted = square_doubt(calibration, board)
    if doubted:
        sentences.append(doubted)
    if found.misfit > MAX_MISFIT:
        sentences.append(
            f"Camera and laser disagree {np.sqrt(found.misfit):.0f} times more than their noise explains; "
            "check the size of the squares, the flatness of the board, the camera's calibration and the clocks. "
            "The uncertainty is widened accordingly."
        )
    if found.offset is not None and abs(found.offset[0]) > 2 * found.offset[1]:
        sentences.append(
            f"The laser measures {found.offset[0] * 1e3:+.0f} mm too far (± {2 * found.offset[1] * 1e3:.0f} mm)."
        )
    return tuple(sentences)


def square_words(calibration: LaserCalibration) -> str:
    """The size of the squares according to the laser."""
    side, sd = calibration.square
    return f"The laser believes the squares are {side * 1e3:.1f} ± {2 * sd * 1e3:.1f} mm"


def square_doubt(calibration: LaserCalibration, board: Board) -> str:
    """'' or a sentence where the laser contradicts the entered size of the squares."""
    side, sd = calibration.square
    if abs(side - board.square) < max(SURE_SDS * sd, CLEAR_SHARE * board.square):
        return ""
    entered = f"{board.square * 1e3:.1f} mm"
    return f"{square_words(calibration)}, not {entered}. Measure five squares with a ruler."


def _landing(found: Extrinsics, model: CameraModel, point: Array) -> LaserLanding:
    """J = d pixel / d P_camera times d P_camera / d mount."""
    away = point - found.transform.translation
    into_camera = found.transform.rotation.T
    by_mount = np.concatenate((into_camera @ cross_matrices(away), -into_camera), axis=1)
    there = Poses(np.eye(3)[None], (into_camera @ away)[None])
    by_space = linearise(vector_of(model), there, np.zeros((1, 3))).by_pose[0][:, 3:]
    spread = by_space @ by_mount @ found.shown_covariance @ (by_space @ by_mount).T
    sideways, up_down = 2 * np.sqrt(np.diag(spread))
    distance = float(np.linalg.norm(point))
    return {"distance_m": distance, "sideways_px": float(sideways), "up_down_px": float(up_down)}
