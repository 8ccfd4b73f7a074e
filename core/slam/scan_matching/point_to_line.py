"""Point-to-line ICP of two views: finer than any grid, once they are nearly right."""

from __future__ import annotations

import math
from copy import copy

import numpy as np
import scipy

from core.geometry import Pose, rotation, wrap
from core.message import Array
from core.perception.landmarks.frame_perception import Beams
from core.slam.map.keyframe import Keyframe

FIRST_REACH_M, LAST_REACH_M = 0.35, 0.1  # within which points belong together in the first and in the last rounds
REACH_FACTOR = 0.75  # from one round to the next
MAX_ROUNDS = 12
MAX_GAP_M, MAX_WALL_M = 0.35, 0.5  # between neighbours on one wall, and across two of them, at most
MIN_NORMALS_COSINE = 0.8  # cosine between two walls that may be one
HALF_WEIGHT_M = 0.05  # off the wall at which a point weighs half
MIN_POINTS = 30  # points
POINT_SD_M = 0.1  # of a point off its wall, their dependence on each other taken in
LEAST = np.array([0.01, 0.01, math.radians(0.2)])  # [m], [rad] sd that is claimed at least
UNKNOWN = np.array([0.5, 0.5, math.radians(10)])  # [m], [rad] sd where no wall gives information
MIN_PAIRED_SHARE = 0.5  # of the points that find their wall, at least


class WallPoints:
    """The points of a view that lie on walls, with the walls' directions."""

    def __init__(self, view: Keyframe | Beams) -> None:
        points = np.asarray(view.ends, np.float64)[view.hits]
        along = points[2:] - points[:-2]
        length = np.hypot(along[:, 0], along[:, 1])
        steps = np.hypot(*(points[1:] - points[:-1]).T) if len(points) else np.zeros(0)
        good = (length < MAX_WALL_M) & (length > 1e-6) & (steps[:-1] < MAX_GAP_M) & (steps[1:] < MAX_GAP_M)
        self.points = points[1:-1][good]  # (M, 2) [m], robot frame
        self.normals = np.column_stack((-along[good, 1], along[good, 0])) / length[good, None]  # (M, 2)
        self._tree = scipy.spatial.KDTree(self.points) if len(self.points) else None

    def thinned(self, most: int) -> WallPoints:
        """At most `most` of these points, evenly; they can be laid on others, not others on them."""
        few, count = copy(self), len(self.points)
        kept = np.arange(min(count, most)) * count // max(min(count, most), 1)
        few.points, few.normals = self.points[kept], self.normals[kept]
        return few

    def nearest(self, points: Array, reach: float) -> tuple[Array, Array]:
        """Points (K, 2) → which of them have a point of these walls within `reach` [m] (K,) bool, and which (K,)."""
        if self._tree is None:
            return np.zeros(len(points), bool), np.zeros(len(points), int)
        distance, index = self._tree.query(points, distance_upper_bound=reach)
        return np.isfinite(distance), np.asarray(index)


def align(base: WallPoints, other: WallPoints, guess: Pose) -> tuple[Pose, Array] | None:
    """Two views and where the other lies, base_from_other, within FAR → where it lies, with covariance (3, 3).

    The covariance is in the base's frame. None where too few points find a wall. Point-to-line matching (Censi, ICRA
    2008) with Cauchy weights.
    """
    if min(len(base.points), len(other.points)) < MIN_POINTS:
        return None
    pose, reach = guess, FIRST_REACH_M
    for _ in range(MAX_ROUNDS):
        pairs = residuals(base, other, pose, reach)
        if pairs is None:
            return None
        off, slopes = pairs
        weights = 1.0 / (1.0 + (off / HALF_WEIGHT_M) ** 2)
        curvature = (slopes * weights[:, None]).T @ slopes
        move = -np.linalg.solve(curvature + 1e-3 * np.eye(3), (slopes * weights[:, None]).T @ off)
        pose = Pose(pose.x + float(move[0]), pose.y + float(move[1]), wrap(pose.heading + float(move[2])))
        if np.abs(move).max() < 1e-4 and reach <= LAST_REACH_M:
            break
        reach = max(LAST_REACH_M, REACH_FACTOR * reach)
    pairs = residuals(base, other, pose, LAST_REACH_M)
    if pairs is None or len(pairs[0]) < MIN_PAIRED_SHARE * len(other.points):
        return None
    off, slopes = pairs
    weights = 1.0 / (1.0 + (off / HALF_WEIGHT_M) ** 2)
    information = (slopes * weights[:, None]).T @ slopes / POINT_SD_M**2
    return pose, np.linalg.inv(information + np.diag(UNKNOWN**-2.0)) + np.diag(LEAST**2)


def residuals(base: WallPoints, other: WallPoints, pose: Pose, reach: float) -> tuple[Array, Array] | None:
    """Return the distances of points from their walls (K,) [m] and their slopes (K, 3) by pose; None: too few."""
    turn = rotation(pose.heading).T
    turned = other.points @ turn
    found, index = base.nearest(turned + np.array([pose.x, pose.y]), reach)
    rows = np.flatnonzero(found)
    walls = index[rows]
    alike = np.abs(((other.normals[rows] @ turn) * base.normals[walls]).sum(axis=1)) > MIN_NORMALS_COSINE
    rows, walls = rows[alike], walls[alike]
    if len(rows) < MIN_POINTS:
        return None
    normals, arms = base.normals[walls], turned[rows]
    off = ((arms + np.array([pose.x, pose.y]) - base.points[walls]) * normals).sum(axis=1)
    return off, np.column_stack((normals, normals[:, 1] * arms[:, 0] - normals[:, 0] * arms[:, 1]))
