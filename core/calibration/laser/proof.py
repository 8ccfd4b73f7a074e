"""Proof that a mount is right: the scan drawn into the picture, and a pose that took no part."""

from typing import NamedTuple

import numpy as np

from core.calibration.board.board import Board
from core.calibration.laser.board_line import select_inside
from core.calibration.laser.range_lines import unit_rays
from core.calibration.laser.solve import LaserPose, range_residuals
from core.calibration.mount import Extrinsics
from core.errors import BadInput
from core.geometry import Transform
from core.message import Array
from core.optics import CameraModel
from core.sensors.laser import Scan


class Check(NamedTuple):
    """Prediction error of a mount for a pose that took no part."""

    residual_rms: float  # [m] along the beams
    off: float  # [pixel] mean distance between where the beams land and where the camera's plane wants them
    beams: int


def dots(scan: Scan, laser_from_camera: Transform, model: CameraModel) -> tuple[Array, Array]:
    """A scan in the picture: (M, 3) u, v [pixel] and range [m] of the points in view, and their beams (M,)."""
    beams = np.flatnonzero(scan.valid)
    ranges = scan.ranges[beams]
    points = unit_rays(scan.angles)[beams] * ranges[:, None]
    pixels = model.project(laser_from_camera.inverse().apply(points))
    with np.errstate(invalid="ignore"):
        inside = np.all((pixels >= 0) & (pixels < (model.width, model.height)), axis=1)
    return np.column_stack((pixels, ranges))[inside], beams[inside]


def check(pose: LaserPose, found: Extrinsics, board: Board, model: CameraModel) -> Check:
    """A pose that took no part → how the mount predicts it. Raises BadInput where the laser misses the board."""
    beams = select_inside(pose.scan, pose.board, board, found)
    if not len(beams):
        raise BadInput("The laser does not meet the board in this pose.")
    residuals = range_residuals(pose, beams, found.guess)
    rays, ranges = pose.scan.rays[beams], pose.scan.ranges[beams]
    into_camera = found.transform.inverse()
    seen = model.project(into_camera.apply(rays * ranges[:, None]))
    wanted = model.project(into_camera.apply(rays * (ranges - residuals)[:, None]))
    off = float(np.nanmean(np.linalg.norm(seen - wanted, axis=1)))
    return Check(float(np.sqrt(np.mean(residuals**2))), off, len(beams))
