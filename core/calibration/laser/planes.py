"""The plane of the board as the camera sees it (eq. 12), and how sure that is."""

import numpy as np

from core.calibration import homography
from core.calibration.board.board import Board
from core.calibration.camera import bundle_adjustment
from core.calibration.camera.bundle_adjustment import BundleSolution, Corners
from core.calibration.projection import Poses, cross_matrices, linearise, vector_of
from core.message import Array, message
from core.optics import CameraModel

MIN_NOISE_PX = 0.05  # no corner is believed better than this


@message
class Plane:
    """normal · P = distance in the camera frame.

    Eq. 12 as printed mixes two frames: N = R3 (R3ᵀ t) needs the board's origin t in the camera frame.
    """

    normal: Array  # (3,), unit length
    distance: float  # [m], positive
    covariance: Array  # (4, 4) of normal and distance


@message
class BoardPose:
    """A board seen by a calibrated camera."""

    rotation: Array  # (3, 3), camera_from_board
    translation: Array  # (3,) [m]
    covariance: Array  # (6, 6) of rotation [rad] and translation [m], moved as R ← exp(δ) R, t ← t + τ
    rms: float  # [pixel], both axes together
    plane: Plane


def board_pose(model: CameraModel, board: Board, corners: Array) -> BoardPose:
    """Corners (N, 2) [pixel] seen by a calibrated camera → the board's pose and plane with their covariances."""
    seen = Corners(board.points, corners[None], np.ones((1, board.count), bool))
    camera = vector_of(model)
    start = BundleSolution(camera, homography.board_poses(board.points, seen.pixels, camera))
    solution = BundleSolution(camera, bundle_adjustment.refine_poses(seen, start, steps=30))
    solution, _ = bundle_adjustment.rescue(seen, solution, ratio=1.0)
    solution = BundleSolution(camera, bundle_adjustment.refine_poses(seen, solution, steps=30))
    squares = float(np.sum(bundle_adjustment.errors(seen, solution) ** 2))
    noise = max(np.sqrt(squares / (2 * board.count - 6)), MIN_NOISE_PX)
    by_pose = linearise(camera, solution.poses, board.points).by_pose[0]
    covariance = noise**2 * np.linalg.inv(by_pose.T @ by_pose)
    return BoardPose(
        rotation=solution.poses.rotations[0],
        translation=solution.poses.translations[0],
        covariance=covariance,
        rms=float(np.sqrt(squares / board.count)),
        plane=plane_of(solution.poses, covariance),
    )


def plane_of(poses: Poses, covariance: Array) -> Plane:
    """The first pose and its covariance (6, 6) → the board's plane."""
    normal, translation = poses.rotations[0][:, 2], poses.translations[0]
    sign = 1.0 if normal @ translation > 0 else -1.0
    normal = sign * normal
    slope = np.zeros((4, 6))
    slope[:3, :3] = -cross_matrices(normal)
    slope[3, :3] = np.cross(normal, translation)
    slope[3, 3:] = normal
    return Plane(normal=normal, distance=float(normal @ translation), covariance=slope @ covariance @ slope.T)
