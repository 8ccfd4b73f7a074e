"""How far a robot that follows a wall is off its distance, where there is one straight wall and nothing else."""

from __future__ import annotations

import math

import numpy as np

from core.geometry import Pose, wrap
from core.message import Array


def aside(truth: Pose, faces: Array, posts: Array, distance: float = 0.5, alone: float = 0.8) -> float | None:
    """How far off `distance` [m] a straight wall on the right is, None where there is more than that one wall.

    `faces` (F, 4) x0 y0 x1 y1 [m] with the open side on the left, `posts` (P, 3) x y radius. It counts where nothing
    else that turns its open side to the robot lies within `alone` [m], the wall lies to the robot's right, and both
    its ends are farther along it than `distance`: nearer to them the way already turns.
    """
    start, edge = faces[:, :2], faces[:, 2:] - faces[:, :2]
    length = np.hypot(*edge.T)
    along = edge / length[:, None]
    away = (truth.x, truth.y) - start
    foot = np.einsum("ij,ij->i", away, along)
    side = along[:, 0] * away[:, 1] - along[:, 1] * away[:, 0]
    gap = np.where(side > 0, np.hypot(side, foot - np.clip(foot, 0.0, length)), np.inf)
    if len(posts) and (np.hypot(*(posts[:, :2] - (truth.x, truth.y)).T) - posts[:, 2] < alone).any():
        return None
    near = np.flatnonzero(gap < alone)
    if len(near) != 1 or not distance < foot[near[0]] < length[near[0]] - distance:
        return None
    turned = wrap(math.atan2(along[near[0], 1], along[near[0], 0]) - truth.heading)
    return float(gap[near[0]] - distance) if abs(turned) < math.radians(45) else None
