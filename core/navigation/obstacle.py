"""Obstacles in the way, by the newest scan."""

import math

import numpy as np

from core.message import Array
from core.sentences import Statement


def free_space(points: Array, radius: float) -> float:
    """Scan points (M, 2) [m] in the robot frame, radius [m] of the body → room [m] around it; inf without points."""
    if not len(points):
        return math.inf
    return max(0.0, float(np.sqrt((points**2).sum(axis=1).min())) - radius)


def obstacle_ahead(points: Array, radius: float, reach: float = 0.5) -> float | None:
    """Scan points (M, 2) [m], robot frame → way [m] until the body touches the first one ahead, if within reach.

    Points up to 4 cm from the body's track count: the gate's guard stops for them too.
    """
    ahead = points[(points[:, 0] > 0) & (np.abs(points[:, 1]) < radius + 0.04)]
    if not len(ahead):
        return None
    way = ahead[:, 0] - np.sqrt(np.maximum(radius**2 - ahead[:, 1] ** 2, 0.0))
    nearest = max(0.0, float(way.min()))
    return nearest if nearest <= reach else None


def why_no_headway(points: Array, radius: float, *, back_up: bool = False) -> Statement:
    """A sentence for the operator: why the robot gets no further; `back_up`: what it does now."""
    gap = obstacle_ahead(points, radius)
    if gap is None:
        return Statement("way.no_headway_back_up" if back_up else "way.no_headway")
    return Statement("way.blocked_back_up" if back_up else "way.blocked_ahead", gap=f"{gap:.2f}")
