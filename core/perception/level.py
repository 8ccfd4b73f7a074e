"""The camera's picture without distortion and levelled: what stands upright in the world stands upright in it."""

from __future__ import annotations

import math
from functools import lru_cache

import cv2
import numpy as np

from core.geometry import OPTICAL, wrap
from core.message import Array
from core.sensors import Camera

WIDEST = 3.0  # rays steeper than this (72 degrees off the axis) are left out


class LevelView:
    """The mapping between a camera's pictures and a level pinhole camera at the same place (eq. 4-6).

    Undistorting the picture rather than the ends of its segments keeps an upright wall edge straight, so that it is
    found in one piece. The look-up tables are made once per camera.
    """

    def __init__(self, camera: Camera) -> None:
        mounting, self.model = camera.mounting.rotation, camera.model
        axis = mounting @ np.array([0.0, 0.0, 1.0])
        self.yaw = math.atan2(axis[1], axis[0])
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        robot_from_level = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ OPTICAL
        self._camera_from_level = mounting.T @ robot_from_level
        self.focal = self.model.fx
        low, high, self._widest = self._bounds()
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

    def _bounds(self) -> tuple[Array, Array, float]:
        """Corners (2,), (2,) of the level rays that the picture covers, and the longest camera ray inside it."""
        u = np.linspace(0, self.model.width - 1, 33)
        v = np.linspace(0, self.model.height - 1, 33)
        border = np.concatenate(
            [np.column_stack((u, np.full(33, end))) for end in (v[0], v[-1])]
            + [np.column_stack((np.full(33, end), v)) for end in (u[0], u[-1])]
        )
        ideal = self.model.unproject(border)
        level = np.column_stack((ideal, np.ones(len(ideal)))) @ self._camera_from_level
        rays = np.clip(level[:, :2] / np.maximum(level[:, 2:], 1e-3), -WIDEST, WIDEST)
        return rays.min(axis=0), rays.max(axis=0), 1.02 * float(np.hypot(ideal[:, 0], ideal[:, 1]).max())


@lru_cache(maxsize=8)
def level_view(camera: Camera) -> LevelView:
    """The level view of a camera, made once."""
    return LevelView(camera)
