"""The distance of a wall in the direction of an edge, by the laser."""

from __future__ import annotations

import math

import numpy as np

from core.geometry import Pose
from core.message import Array

ASIDE = math.radians(4)  # of the direction in which the wall's points are looked at
FEWEST = 6  # points of a wall
STRAIGHT = 0.03  # [m] rms off the line, at most
GRAZING = math.radians(8)  # between the wall and the direction, at least


def wall_range(points: Array, eye: Pose, bearing: float, sd: float, wall_sd: float) -> tuple[float, float] | None:
    """Points (K, 2) [m] of a scan, robot frame; a bearing [rad] of an eye → range [m] of the wall there and its sd.

    `sd` [rad] of the bearing, `wall_sd` [m] across the wall. None where the laser sees no straight wall.
    """
    seen = eye.inverse().apply(points)
    off = (np.arctan2(seen[:, 1], seen[:, 0]) - bearing + np.pi) % (2 * np.pi) - np.pi
    near = seen[np.abs(off) < ASIDE]
    if len(near) < FEWEST or off.min() > 0 or off.max() < 0:
        return None
    middle = near.mean(axis=0)
    values, vectors = np.linalg.eigh((near - middle).T @ (near - middle) / len(near))
    if math.sqrt(max(float(values[0]), 0.0)) > STRAIGHT:
        return None
    normal = vectors[:, 0]
    ray = np.array([math.cos(bearing), math.sin(bearing)])
    slope = float(normal @ ray)
    if abs(slope) < math.sin(GRAZING):
        return None
    reach = float(normal @ middle) / slope
    along = math.sqrt(max(1 - slope**2, 0.0)) / abs(slope)
    return reach, math.hypot(wall_sd / slope, reach * along * sd)
