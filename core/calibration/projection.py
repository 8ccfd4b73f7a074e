"""Many views of one board through one camera at once, with derivatives (eq. 1-6).

The camera is a vector (9,) in the order of `PARAMETERS`. A board's pose is its rotation (3, 3) and translation (3,)
into the camera frame; it is moved by (rotation vector, translation) as R ← exp(δ) R, t ← t + τ.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from core.message import Array
from core.optics import CameraModel

PARAMETERS = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3")
PAPER = tuple(range(8))  # the paper's eight of Table 3
BY_ROW = 7  # columns by the row: skew, then a motion of the pose
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
    """Rotation vectors (M, 3) [rad] → rotation matrices (M, 3, 3), by Rodrigues' formula."""
    angles, turn = np.linalg.norm(vectors, axis=1)[:, None, None], cross_matrices(vectors)
    return np.eye(3) + np.sinc(angles / np.pi) * turn + 0.5 * np.sinc(angles / (2 * np.pi)) ** 2 * (turn @ turn)


def cross_matrices(vectors: Array) -> Array:
    """Vectors (..., 3) → matrices (..., 3, 3) with `matrix @ other = vector × other`."""
    matrices = np.zeros((*vectors.shape, 3))
    for axis, (row, column) in enumerate(((2, 1), (0, 2), (1, 0))):
        matrices[..., row, column] = vectors[..., axis]
        matrices[..., column, row] = -vectors[..., axis]
    return matrices


def vector_of(model: CameraModel) -> Array:
    """A camera → its vector (9,)."""
    return np.array([getattr(model, name) for name in PARAMETERS])


def model_of(vector: Array, size: tuple[int, int]) -> CameraModel:
    """A vector (9,) and the picture's width and height [pixel] → the camera."""
    numbers = {name: float(value) for name, value in zip(PARAMETERS, vector, strict=True)}
    return CameraModel(width=size[0], height=size[1], **numbers)


def project(camera: Array, poses: Poses, points: Array) -> Array:
    """Points (N, 3) [m] of the board in M poses → pixels (M, N, 2)."""
    space = poses.rotations @ points.T + poses.translations[:, :, None]
    place = space[:, :2] / np.maximum(space[:, 2:], MIN_DEPTH_M)
    x, y = place[:, 0], place[:, 1]
    k1, k2, p1, p2, k3 = camera[4:9]
    r2, cross = x * x + y * y, 2 * x * y
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    pixels = np.empty((*x.shape, 2))
    pixels[..., 0] = camera[0] * (x * radial + p1 * cross + p2 * (r2 + 2 * x * x)) + camera[2]
    pixels[..., 1] = camera[1] * (y * radial + p1 * (r2 + 2 * y * y) + p2 * cross) + camera[3]
    return pixels


class Linearised(NamedTuple):
    """Pixels and their derivatives; the rows of all points' u come before those of v."""

    pixels: Array  # (M, N, 2)
    columns: Array  # (M, 15 + K, 2N): by camera (9), by pose (6: rotation, then translation), by shapes and rows

    @property
    def by_camera(self) -> Array:
        """(M, 2N, 9)."""
        return np.swapaxes(self.columns[:, :9], 1, 2)

    @property
    def by_pose(self) -> Array:
        """(M, 2N, 6)."""
        return np.swapaxes(self.columns[:, 9:15], 1, 2)


def linearise(
    camera: Array, poses: Poses, points: Array, shapes: Sequence[Array] = (), *, rows: bool = False
) -> Linearised:
    """Points (N, 3) [m] of the board in M poses → pixels with derivatives by camera, pose and K shapes.

    `shapes`: displacements (N, 3) of the points per unit, in the board's frame. `rows`: after them the picture's skew
    [pixel], then a motion of the pose, each by the row, which counts in focal lengths from the principal point.
    """
    turned = poses.rotations @ points.T
    depth = np.maximum(turned[:, 2] + poses.translations[:, 2:], MIN_DEPTH_M)
    place = (turned[:, :2] + poses.translations[:, :2, None]) / depth[:, None]
    columns = np.empty((len(depth), 15 + len(shapes) + BY_ROW * rows, 2, len(points)))
    pixels = _fill_by_camera(camera, place, columns)
    by_space = columns[:, 12:15]
    _fill_by_space(camera, place, depth, by_space)
    for axis, (one, other) in enumerate(((1, 2), (2, 0), (0, 1))):  # turned × gradient
        np.multiply(turned[:, None, one], by_space[:, other], out=columns[:, 9 + axis])
        columns[:, 9 + axis] -= turned[:, None, other] * by_space[:, one]
    for number, shape in enumerate(shapes):
        moved = poses.rotations @ shape.T
        columns[:, 15 + number] = sum(moved[:, None, axis] * by_space[:, axis] for axis in range(3))
    if rows:
        row = columns[:, 1, 1]
        columns[:, -BY_ROW, 0], columns[:, -BY_ROW, 1] = row, 0.0
        np.multiply(columns[:, 9:15], row[:, None, None], out=columns[:, 1 - BY_ROW :])
    return Linearised(np.swapaxes(pixels, 1, 2), columns.reshape(*columns.shape[:2], 2 * len(points)))


def _fill_by_camera(camera: Array, place: Array, columns: Array) -> Array:
    """Ideal coordinates (M, 2, N) → pixels (M, 2, N); the first nine columns get their derivatives by the camera."""
    x, y = place[:, 0], place[:, 1]
    focal, (k1, k2, p1, p2, k3) = camera[:2, None], camera[4:9]
    r2, cross = x * x + y * y, 2 * x * y
    scaled = focal * place
    np.multiply(scaled, r2[:, None], out=columns[:, 4])
    np.multiply(columns[:, 4], r2[:, None], out=columns[:, 5])
    np.multiply(columns[:, 5], r2[:, None], out=columns[:, 8])
    columns[:, 6, 0], columns[:, 6, 1] = focal[0] * cross, focal[1] * (r2 + 2 * y * y)
    columns[:, 7, 0], columns[:, 7, 1] = focal[0] * (r2 + 2 * x * x), focal[1] * cross
    for number, coefficient in ((4, k1), (5, k2), (6, p1), (7, p2), (8, k3)):
        if coefficient:
            scaled += coefficient * columns[:, number]
    columns[:, :4] = 0.0
    columns[:, 0, 0], columns[:, 1, 1] = scaled[:, 0] / focal[0], scaled[:, 1] / focal[1]
    columns[:, 2, 0] = columns[:, 3, 1] = 1.0
    return scaled + camera[2:4, None]


def _fill_by_space(camera: Array, place: Array, depth: Array, by_space: Array) -> None:
    """Fill (M, 3, 2, N): the pixels' derivatives by the points in the camera frame."""
    x, y = place[:, 0], place[:, 1]
    k1, k2, p1, p2, k3 = camera[4:9]
    r2 = x * x + y * y
    radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3))
    slope = 2 * (k1 + r2 * (2 * k2 + r2 * 3 * k3))
    mixed = x * y * slope + 2 * (p1 * x + p2 * y)
    across = camera[0] / depth, camera[1] / depth
    by_space[:, 0, 0] = across[0] * (radial + x * x * slope + 2 * p1 * y + 6 * p2 * x)
    by_space[:, 1, 1] = across[1] * (radial + y * y * slope + 6 * p1 * y + 2 * p2 * x)
    by_space[:, 1, 0], by_space[:, 0, 1] = across[0] * mixed, across[1] * mixed
    np.multiply(by_space[:, 0], -x[:, None], out=by_space[:, 2])
    by_space[:, 2] -= by_space[:, 1] * y[:, None]
