"""Initial values: the direct linear transform of a flat board (eq. 7-8) and what follows from it.

Every corner of a flat board has z = 0, so three columns of eq. 8 vanish and what remains is the homography from the
board to the picture; focal lengths and poses follow from several of them.
"""

from typing import NamedTuple

import numpy as np

from core.calibration.projection import Poses
from core.message import Array

MOST_FOCAL = 100.0  # times the picture's longer side: beyond it, it is rounding that speaks
RIDGE_SHARE = 1e-12  # keeps corners that lie on one spot from having no answer at all


class Start(NamedTuple):
    """The starting point of the refinement."""

    camera: Array  # (9,), without distortion
    poses: Poses
    focal_known: bool  # False: the views say nothing about the focal length and a usual one is assumed


def homographies(points: Array, pixels: Array) -> Array:
    """Board points (N, 3) with z = 0 and pixels (M, N, 2) → homographies (M, 3, 3), pixel ~ H (x, y, 1)."""
    flat, from_flat = _centred(points[None, :, :2])
    seen, from_seen = _centred(pixels)
    views, count = pixels.shape[:2]
    ground = np.broadcast_to(np.concatenate((flat, np.ones((1, count, 1))), axis=-1), (views, count, 3))
    rows = np.zeros((views, count, 2, 9))
    rows[..., 0, 0:3] = rows[..., 1, 3:6] = ground
    rows[..., 0, 6:9] = -seen[..., 0:1] * ground
    rows[..., 1, 6:9] = -seen[..., 1:2] * ground
    stacked = rows.reshape(views, 2 * count, 9)
    product = np.swapaxes(stacked, 1, 2) @ stacked
    solved = np.linalg.solve(product[:, :8, :8] + RIDGE_SHARE * count * np.eye(8), -product[:, :8, 8:])
    mapping = np.concatenate((solved[..., 0], np.ones((views, 1))), axis=1)  # the board's middle is never at infinity
    return np.linalg.inv(from_seen) @ mapping.reshape(views, 3, 3) @ from_flat


def start(points: Array, pixels: Array, size: tuple[int, int], mapping: Array | None = None) -> Start:
    """Board points (N, 3), their pixels (M, N, 2), picture size → camera and poses without distortion.

    `mapping` (M, 3, 3): their homographies, where they are known.
    """
    mapping = homographies(points, pixels) if mapping is None else mapping
    centre = np.array([(size[0] - 1) / 2, (size[1] - 1) / 2])
    focal = focal_lengths(mapping, centre)
    known = focal is not None and focal.max() < MOST_FOCAL * max(size)
    if focal is None or not known:
        focal = np.full(2, float(max(size)))
    camera = np.array([focal[0], focal[1], centre[0], centre[1], 0.0, 0.0, 0.0, 0.0, 0.0])
    return Start(camera, board_poses(points, pixels, camera, mapping), known)


def focal_lengths(mapping: Array, centre: Array) -> Array | None:
    """Homographies (M, 3, 3) and the principal point (2,) → (fx, fy), or None when the views do not determine it.

    The first two columns of K⁻¹H are perpendicular and equally long: two linear equations in 1/fx² and 1/fy² a view.
    """
    shifted = mapping.copy()
    shifted[:, :2] -= centre[:, None] * mapping[:, 2:3]
    shifted /= np.sqrt(np.sum(shifted[:, :, :2] ** 2, axis=(1, 2)))[:, None, None]
    (a, b), (c, d), (e, f) = (shifted[:, row, :2].T for row in range(3))
    left = np.concatenate((np.column_stack((a * b, c * d)), np.column_stack((a * a - b * b, c * c - d * d))))
    right = -np.concatenate((e * f, e * e - f * f))
    inverse = np.linalg.lstsq(left, right, rcond=None)[0]
    if np.all(inverse > 0):
        return 1 / np.sqrt(inverse)
    both = left.sum(axis=1)
    common = float(both @ right / max(float(both @ both), 1e-300))
    return np.full(2, 1 / np.sqrt(common)) if common > 0 else None


def poses(mapping: Array, camera: Array) -> Poses:
    """Homographies (M, 3, 3) and a camera (9,) → the poses of the board (distortion left out)."""
    scaled = mapping.copy()
    scaled[:, :2] -= camera[2:4, None] * mapping[:, 2:3]
    scaled[:, :2] /= camera[:2, None]
    lengths = np.linalg.norm(scaled[:, :, :2], axis=1).mean(axis=1)
    scaled *= (np.where(scaled[:, 2, 2] < 0, -1.0, 1.0) / lengths)[:, None, None]
    first, second = scaled[:, :, 0], scaled[:, :, 1]
    left, _, right = np.linalg.svd(np.stack((first, second, np.cross(first, second)), axis=-1))
    return Poses(left @ right, scaled[:, :, 2])


def board_poses(points: Array, pixels: Array, camera: Array, mapping: Array | None = None) -> Poses:
    """Board points (N, 3), pixels (M, N, 2), camera (9,) → poses, all in front of the camera.

    `mapping` (M, 3, 3): their homographies, where they are known.

    Where the corners are so wrong that the homography puts some of them behind it, the board faces the camera.
    """
    found = poses(homographies(points, pixels) if mapping is None else mapping, camera)
    behind = found.points(points)[..., 2].min(axis=1) <= 0
    spread = np.linalg.norm(points - points.mean(axis=0), axis=1).mean()
    seen = (pixels - camera[2:4]) / camera[:2]
    middle = seen.mean(axis=1)
    depth = spread / np.linalg.norm(seen - middle[:, None], axis=2).mean(axis=1)
    facing = np.column_stack((middle, np.ones(len(middle)))) * depth[:, None] - points.mean(axis=0)
    return Poses(
        np.where(behind[:, None, None], np.eye(3), found.rotations),
        np.where(behind[:, None], facing, found.translations),
    )


def _centred(points: Array) -> tuple[Array, Array]:
    """Points (M, N, 2) → the same about their mean with mean distance √2, and the maps (M, 3, 3) that do it."""
    mean = points.mean(axis=1, keepdims=True)
    scale = np.sqrt(2) / np.linalg.norm(points - mean, axis=2).mean(axis=1)
    maps = np.zeros((len(points), 3, 3))
    maps[:, 0, 0] = maps[:, 1, 1] = scale
    maps[:, :2, 2] = -scale[:, None] * mean[:, 0]
    maps[:, 2, 2] = 1.0
    return (points - mean) * scale[:, None, None], maps
