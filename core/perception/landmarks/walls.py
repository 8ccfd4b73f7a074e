"""The distance of a wall in the direction of an edge, by the laser."""

import math

import numpy as np

from core.geometry import Pose
from core.message import Array

ASIDE = math.radians(4)  # of the direction in which the wall's points are looked at
MIN_POINTS = 6  # points of a wall
MAX_WALL_RMS_M = 0.03  # rms off the line, at most
GRAZING = math.radians(8)  # between the wall and the direction, at least


class SeenWalls:
    """The points of a scan, as an eye sees them."""

    def __init__(self, points: Array, eye: Pose) -> None:
        """`points` (K, 2) [m] of the scan, robot frame; `eye` is robot_from_eye."""
        self._points = eye.inverse().apply(points)
        self._angles = np.arctan2(self._points[:, 1], self._points[:, 0])

    def near(self, bearing: float) -> Array | None:
        """Points (N, 2) [m], eye's frame, around a bearing [rad], some on either side; None: too few."""
        off = (self._angles - bearing + np.pi) % (2 * np.pi) - np.pi
        beside = np.flatnonzero(np.abs(off) < ASIDE)
        if len(beside) < MIN_POINTS or off[beside].min() > 0 or off[beside].max() < 0:
            return None
        return self._points[beside]


def wall_range(walls: SeenWalls, bearing: float, sd: float, wall_sd: float) -> tuple[float, float] | None:
    """A bearing [rad] of an eye → range [m] of the wall there and its sd.

    `sd` [rad] of the bearing, `wall_sd` [m] across the wall. None where the laser sees no straight wall.
    """
    near = walls.near(bearing)
    if near is None:
        return None
    middle = near.mean(axis=0)
    values, vectors = np.linalg.eigh((near - middle).T @ (near - middle) / len(near))
    if math.sqrt(max(float(values[0]), 0.0)) > MAX_WALL_RMS_M:
        return None
    normal = vectors[:, 0]
    ray = np.array([math.cos(bearing), math.sin(bearing)])
    slope = float(normal @ ray)
    if abs(slope) < math.sin(GRAZING):
        return None
    reach = float(normal @ middle) / slope
    along = math.sqrt(max(1 - slope**2, 0.0)) / abs(slope)
    return reach, math.hypot(wall_sd / slope, reach * along * sd)
