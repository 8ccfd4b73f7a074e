"""Many views of one board through one camera at once, with derivatives (eq. 1-6).

The camera is a vector (9,) in the order of `PARAMETERS`. A board's pose is its rotation (3, 3) and translation (3,)
into the camera frame; it is moved by (rotation vector, translation) as R ← exp(δ) R, t ← t + τ.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from core.message import Array
from core.optics import CameraModel

PARAMETERS = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3")
PAPER = tuple(range(8))  # the paper's eight of Table 3
MIN_DEPTH_M = 1e-3  # points nearer than this, or behind the camera, are projected as if they were here


class Poses(NamedTuple):
    """Poses of the board in M views, `camera_from_board`."""

    rotations: Array  # (M, 3, 3)
    translations: Array  # (M, 3) [m]

    def moved(self, steps: Array) -> Poses:
        """Steps (M, 6) of rotation [rad] and translation [m] → the moved poses."""
        return Poses(exponential(steps[:, :3]) @ self.rotations, self.translations + steps[:, 3:])

    def take(self, which: Array | slice) -> Poses:
        """The chosen views."""
        return Poses(self.rotations[which], self.translations[which])

    def points(self, points: Array) -> Array:
        """Points (N, 3) [m] of the board → (M, N, 3) [m] in the camera frame."""
        return points @ np.swapaxes(self.rotations, 1, 2) + self.translations[:, None, :]


def exponential(vectors: Array) -> Array:
    """Rotation vectors (M, 3) [rad] → rotation matrices (M, 3, 3)."""
    return Rotation.from_rotvec(vectors).as_matrix()


def cross_matrices(vectors: Array) -> Array:
    """Vectors (..., 3) → matrices (..., 3, 3) with `matrix @ other = vector × other`."""
    zero = np.zeros(vectors.shape[:-1])
    x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
    return np.stack((zero, -z, y, z, zero, -x, -y, x, zero), axis=-1).reshape(*vectors.shape[:-1], 3, 3)


def vector_of(model: CameraModel) -> Array:
    """A camera → its vector (9,)."""
    return np.array([getattr(model, name) for name in PARAMETERS])


def model_of(vector: Array, size: tuple[int, int]) -> CameraModel:
    """A vector (9,) and the picture's width and height [pixel] → the camera."""
    numbers = {name: float(value) for name, value in zip(PARAMETERS, vector, strict=True)}
    return CameraModel(width=size[0], height=size[1], **numbers)


def project(camera: Array, poses: Poses, points: Array) -> Array:
    """Points (N, 3) [m] of the board in M poses → pixels (M, N, 2)."""
    space = poses.points(points)
    return camera[:2] * _distort(camera, *_normalised(space)[:2])[0] + camera[2:4]


class Linearised(NamedTuple):
    """Pixels and their derivatives; rows u, v interleaved per point."""

    pixels: Array  # (M, N, 2)
    by_camera: Array  # (M, 2N, 9)
    by_pose: Array  # (M, 2N, 6), rotation then translation


def linearise(camera: Array, poses: Poses, points: Array) -> Linearised:
    """Points (N, 3) [m] of the board in M poses → pixels with derivatives by camera and by pose."""
    turned = points @ np.swapaxes(poses.rotations, 1, 2)
    space = turned + poses.translations[:, None, :]
    x, y, depth = _normalised(space)
    distorted, r2, radial, slope = _distort(camera, x, y)
    fx, fy, p1, p2 = camera[0], camera[1], camera[6], camera[7]
    views, count = x.shape

    by_camera = np.zeros((views, count, 2, 9))
    by_camera[..., 0, 0], by_camera[..., 1, 1] = distorted[..., 0], distorted[..., 1]
    by_camera[..., 0, 2] = by_camera[..., 1, 3] = 1.0
    shapes = np.stack((r2, r2 * r2, r2 * r2 * r2), axis=-1)
    for row, (focal, along) in enumerate(((fx, x), (fy, y))):
        by_camera[..., row, 4:6] = focal * along[..., None] * shapes[..., :2]
        by_camera[..., row, 8] = focal * along * shapes[..., 2]
    by_camera[..., 0, 6] = 2 * fx * x * y
    by_camera[..., 0, 7] = fx * (r2 + 2 * x * x)
    by_camera[..., 1, 6] = fy * (r2 + 2 * y * y)
    by_camera[..., 1, 7] = 2 * fy * x * y

    mixed = 2 * x * y * slope + 2 * p1 * x + 2 * p2 * y
    along_x = radial + 2 * x * x * slope + 2 * p1 * y + 6 * p2 * x
    along_y = radial + 2 * y * y * slope + 6 * p1 * y + 2 * p2 * x
    by_space = np.empty((views, count, 2, 3))
    for row, (focal, by_x, by_y) in enumerate(((fx, along_x, mixed), (fy, mixed, along_y))):
        by_space[..., row, 0] = focal * by_x / depth
        by_space[..., row, 1] = focal * by_y / depth
        by_space[..., row, 2] = -focal * (by_x * x + by_y * y) / depth
    by_rotation = np.empty_like(by_space)
    for axis, (one, other) in enumerate(((1, 2), (2, 0), (0, 1))):  # turned × gradient
        by_rotation[..., axis] = (
            turned[..., None, one] * by_space[..., other] - turned[..., None, other] * by_space[..., one]
        )
    by_pose = np.concatenate((by_rotation, by_space), axis=-1)
    pixels = camera[:2] * distorted + camera[2:4]
    return Linearised(pixels, by_camera.reshape(views, 2 * count, 9), by_pose.reshape(views, 2 * count, 6))


def _normalised(space: Array) -> tuple[Array, Array, Array]:
    """Camera-frame points (M, N, 3) → x/z, y/z and the depth (M, N), kept positive."""
    depth = np.maximum(space[..., 2], MIN_DEPTH_M)
    return space[..., 0] / depth, space[..., 1] / depth, depth


def _distort(camera: Array, x: Array, y: Array) -> tuple[Array, Array, Array, Array]:
    """Ideal coordinates (M, N) → distorted (M, N, 2), r², the radial factor and its slope by r² (eq. 4-5)."""
    k1, k2, p1, p2, k3 = camera[4:9]
    r2 = x * x + y * y
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    slope = k1 + r2 * (2 * k2 + r2 * 3 * k3)
    cross = 2 * x * y
    distorted = np.stack(
        (x * radial + p1 * cross + p2 * (r2 + 2 * x * x), y * radial + p1 * (r2 + 2 * y * y) + p2 * cross), axis=-1
    )
    return distorted, r2, radial, slope
