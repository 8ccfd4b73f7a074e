"""The camera's picture without distortion and levelled: what stands upright in the world stands upright in it."""

import math
from functools import lru_cache

import cv2
import numpy as np

from core.errors import BadInput
from core.geometry import OPTICAL, wrap
from core.message import Array
from core.optics import CameraModel
from core.sensors import Camera

MIN_SIDE, MAX_GROWTH = 8, 16  # [pixel] of a level picture, and its area in areas of the camera's
MAX_STEEPNESS = 3.0  # rays steeper than this (72 degrees off the axis) are left out


class LevelView:
    """The mapping between a camera's pictures and a level pinhole camera at the same place (eq. 4-6).

    Undistorting the picture rather than the ends of its segments keeps an upright wall edge straight, so that it is
    found in one piece. The look-up tables are made once per camera.
    """

    def __init__(self, camera: Camera) -> None:
        """Raises BadInput for a camera whose picture cannot be levelled."""
        self.model, self.focal = camera.model, camera.model.fx
        self.yaw, self._camera_from_level = _level_axes(camera)
        low, high = level_bounds(camera)
        rim = np.linalg.norm(self.model.unproject(_rim(self.model)), axis=1)
        self._widest = min(1.02 * float(np.nanmax(rim)), self.model.turning_radius)
        self.width, self.height = (np.ceil((high - low) * self.focal).astype(int) + 1).tolist()
        self._centre = -low * self.focal
        u, v = np.meshgrid(np.arange(self.width, dtype=float), np.arange(self.height, dtype=float))
        pixels = self.to_picture(np.column_stack((u.ravel(), v.ravel())))
        maps = np.nan_to_num(pixels, nan=-1e4).astype(np.float32).reshape(self.height, self.width, 2)
        self._map_u, self._map_v = cv2.convertMaps(maps[..., 0], maps[..., 1], cv2.CV_16SC2)
        size = (self.model.height, self.model.width)
        seen = cv2.remap(np.full(size, 255, np.uint8), self._map_u, self._map_v, cv2.INTER_LINEAR)
        self.inside = cv2.erode(seen, np.ones((7, 7), np.uint8)) == 255  # (height, width) bool: away from the border

    def to_picture(self, pixels: Array) -> Array:
        """Level pixels (N, 2) → pixels (N, 2) of the picture as delivered; NaN where the camera does not see."""
        rays = (
            np.column_stack(((pixels - self._centre) / self.focal, np.ones(len(pixels)))) @ self._camera_from_level.T
        )
        ideal = rays[:, :2] / np.where(rays[:, 2:] > 1e-6, rays[:, 2:], np.nan)
        ideal[np.hypot(ideal[:, 0], ideal[:, 1]) > self._widest] = np.nan  # beyond, the polynomial folds back
        return self.model.distort(ideal) * (self.model.fx, self.model.fy) + (self.model.cx, self.model.cy)

    def warp(self, picture: Array) -> Array:
        """Picture (H, W) → level picture (height, width)."""
        return cv2.remap(picture, self._map_u, self._map_v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)

    def bearing(self, column: float) -> float:
        """A column of the level picture → bearing [rad] in the robot's axes, seen from the camera."""
        return wrap(self.yaw - math.atan((column - self._centre[0]) / self.focal))


def level_bounds(camera: Camera) -> tuple[Array, Array]:
    """Corners (2,), (2,) of the level rays that the picture covers.

    Raises BadInput for a camera whose picture cannot be levelled.
    """
    model, (_, camera_from_level) = camera.model, _level_axes(camera)
    ideal = model.unproject(_rim(model))
    level = np.column_stack((ideal, np.ones(len(ideal)))) @ camera_from_level
    rays = np.clip(level[:, :2] / np.maximum(level[:, 2:], 1e-3), -MAX_STEEPNESS, MAX_STEEPNESS)
    rays = rays[np.isfinite(rays).all(axis=1)]
    size = np.ptp(rays, axis=0) * model.fx if len(rays) else np.zeros(2)
    if not (size.min() >= MIN_SIDE and size.prod() <= MAX_GROWTH * model.width * model.height):
        raise BadInput(
            "The camera's picture cannot be levelled: its calibration or its mount is not that of a camera which "
            "looks across the floor."
        )
    return rays.min(axis=0), rays.max(axis=0)


def _level_axes(camera: Camera) -> tuple[float, Array]:
    """The heading [rad] in which the camera looks, and the rotation camera_from_level (3, 3)."""
    mounting = camera.mounting.rotation
    axis = mounting @ np.array([0.0, 0.0, 1.0])
    yaw = math.atan2(axis[1], axis[0])
    c, s = math.cos(yaw), math.sin(yaw)
    return yaw, mounting.T @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ OPTICAL


def _rim(model: CameraModel) -> Array:
    """Pixels (132, 2) along the border of the picture."""
    u = np.linspace(0, model.width - 1, 33)
    v = np.linspace(0, model.height - 1, 33)
    return np.concatenate(
        [np.column_stack((u, np.full(33, end))) for end in (v[0], v[-1])]
        + [np.column_stack((np.full(33, end), v)) for end in (u[0], u[-1])]
    )


@lru_cache(maxsize=8)
def level_view(camera: Camera) -> LevelView:
    """The level view of a camera, made once."""
    return LevelView(camera)
