"""Covariance of a scan match, from the directions of the walls in the scan."""

from __future__ import annotations

import numpy as np

from core.message import Array


def match_spread(
    points: Array, *, point_sd: float, wall: float, unknown: Array, floor: Array, believed: Array | None = None
) -> Array:
    """Points (M, 2) [m] of a scan, robot frame, in the order of their beams → covariance (3, 3) of its pose.

    In the robot frame at the matched pose: x [m], y [m], heading [rad]. Every point measures its distance across
    its wall, with `point_sd` [m], the points' dependence on each other taken in; a wall's direction is that between
    next neighbours at most `wall` [m] apart. `unknown` (3,) is the sd where no wall gives information, `floor` (3,)
    the least sd that is ever claimed, `believed` (M,) 0..1 how much each point counts.
    """
    along = points[2:] - points[:-2]
    reach = np.hypot(along[:, 0], along[:, 1])
    on_wall = (reach > 1e-6) & (reach < wall)
    normals = np.column_stack((-along[on_wall, 1], along[on_wall, 0])) / reach[on_wall, None]
    middle = points[1:-1][on_wall]
    turning = middle[:, 0] * normals[:, 1] - middle[:, 1] * normals[:, 0]
    slopes = np.column_stack((normals, turning)) / point_sd
    if believed is not None:
        slopes = slopes * np.sqrt(believed[1:-1][on_wall])[:, None]
    return np.linalg.inv(slopes.T @ slopes + np.diag(unknown**-2.0)) + np.diag(floor**2)
