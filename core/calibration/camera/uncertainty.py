"""Projection error of a calibrated camera: a map over the picture, in pixels."""

from typing import NamedTuple

import numpy as np

from core.calibration.camera import bundle_adjustment
from core.calibration.camera.bundle_adjustment import BundleSolution, Corners
from core.calibration.camera.intrinsics import Calibration
from core.calibration.projection import PAPER, PARAMETERS, Poses, linearise, vector_of
from core.message import Array, message
from core.optics import CameraModel

MAP_COLUMNS, MAP_ROWS = 15, 11  # of the map
AHEAD = Poses(np.eye(3)[None], np.zeros((1, 3)))


@message
class UncertaintyMap:
    """Standard deviation of the projection of a distant point, after the best turn of the whole camera."""

    pixels: Array  # (ROWS, COLUMNS, 2)
    sd: Array  # (ROWS, COLUMNS) [pixel], along the worst direction; NaN where the camera model reaches no ray

    @property
    def p95(self) -> float:
        """[pixel]: 95 % of the picture is known better than this; inf where nothing is known."""
        known = self.sd[np.isfinite(self.sd)]
        return float(np.quantile(known, 0.95)) if len(known) else float("inf")

    @property
    def median(self) -> float:
        """[pixel]."""
        return float(np.nanmedian(self.sd))

    @property
    def worst(self) -> float:
        """[pixel]."""
        return float(np.nanmax(self.sd))


class Sensitivity(NamedTuple):
    """Motion of pixels with the camera's parameters, once the camera may turn freely."""

    pixels: Array  # (G, 2)
    by_camera: Array  # (G, 2, P)


def uncertainty_map(calibration: Calibration) -> UncertaintyMap:
    """A calibration → where in the picture it can be trusted."""
    free = tuple(PARAMETERS.index(name) for name in calibration.free)
    used = calibration.corners.used
    around = calibration.corners.pixels[used]
    return map_of(sensitivity(calibration.model, free, around), calibration.covariance)


def map_of(grid: Sensitivity, covariance: Array) -> UncertaintyMap:
    """The grid's sensitivity and the covariance (P, P) of the free parameters → the map."""
    spread = grid.by_camera @ covariance @ np.swapaxes(grid.by_camera, 1, 2)
    known = np.isfinite(spread).all(axis=(1, 2))
    sd = np.full(len(spread), np.nan)
    sd[known] = np.sqrt(np.maximum(np.linalg.eigvalsh(spread[known])[:, -1], 0.0))
    return UncertaintyMap(pixels=grid.pixels.reshape(MAP_ROWS, MAP_COLUMNS, 2), sd=sd.reshape(MAP_ROWS, MAP_COLUMNS))


def sensitivity(model: CameraModel, free: tuple[int, ...], around: Array | None = None) -> Sensitivity:
    """The grid's derivatives by the `free` parameters, less what a turn of the camera would explain.

    The turn is the one that best fits the pixels `around` (K, 2), the corners that were seen; by default the grid.
    """
    grid = map_pixels(model)
    by_camera, by_turn = _derivatives(model, grid, free)
    if around is None or len(around) == 0:
        seen_camera, seen_turn = by_camera, by_turn
    else:
        seen_camera, seen_turn = _derivatives(model, around, free)
    known = np.isfinite(seen_camera).all(axis=(1, 2))
    turn = np.linalg.lstsq(seen_turn[known].reshape(-1, 3), seen_camera[known].reshape(-1, len(free)), rcond=None)[0]
    return Sensitivity(grid, by_camera - by_turn @ turn)


def map_pixels(model: CameraModel) -> Array:
    """The map's pixels (G, 2), row by row, from rim to rim."""
    u, v = np.linspace(0, model.width - 1, MAP_COLUMNS), np.linspace(0, model.height - 1, MAP_ROWS)
    return np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 2)


def view_information(camera: Array, poses: Poses, points: Array, noise: float) -> Array:
    """Information (M, 8, 8) about the paper's parameters from a view of the board in each pose."""
    shown = Corners(
        points, np.zeros((len(poses.rotations), len(points), 2)), np.ones((len(poses.rotations), len(points)), bool)
    )
    return bundle_adjustment.information(shown, BundleSolution(camera, poses), PAPER) / noise**2


def _derivatives(model: CameraModel, pixels: Array, free: tuple[int, ...]) -> tuple[Array, Array]:
    """Pixels (K, 2) → their derivatives by the free parameters (K, 2, P) and by a turn of the camera (K, 2, 3)."""
    ideal = model.undistort((pixels - (model.cx, model.cy)) / (model.fx, model.fy))
    rays = np.column_stack((ideal, np.ones(len(pixels))))
    columns = linearise(vector_of(model), AHEAD, rays).columns[0].reshape(15, 2, -1).transpose(2, 1, 0)
    return columns[:, :, list(free)], columns[:, :, len(PARAMETERS) : len(PARAMETERS) + 3]
