"""Covariance of a scan match, from the directions of the walls in the scan."""

from __future__ import annotations

import numpy as np

from core.message import Array

NEIGHBOURS = 16  # points to either side among which they are, at most
BENT = 0.05  # [m] of a point off the line between them, at most


def match_spread(
    points: Array, *, point_sd: float, wall: float, unknown: Array, floor: Array, believed: Array | None = None
) -> Array:
    """Points (M, 2) [m] of a scan, robot frame, in the order of their beams → covariance (3, 3) of its pose.

    In the robot frame at the matched pose: x [m], y [m], heading [rad]. Every point measures its distance across
    its wall, with `point_sd` [m], the points' dependence on each other taken in; a wall's direction is that between
    neighbours on either side, at most `wall` [m] apart. `unknown` (3,) is the sd where no wall gives information,
    `floor` (3,) the least sd that is ever claimed, `believed` (M,) 0..1 how much each point counts.
    """
    rows, along = _on_walls(points, wall)
    normals = np.column_stack((-along[:, 1], along[:, 0]))
    middle = points[rows]
    turning = middle[:, 0] * normals[:, 1] - middle[:, 1] * normals[:, 0]
    slopes = np.column_stack((normals, turning)) / point_sd
    if believed is not None:
        slopes = slopes * np.sqrt(believed[rows])[:, None]
    return np.linalg.inv(slopes.T @ slopes + np.diag(unknown**-2.0)) + np.diag(floor**2)


def _on_walls(points: Array, wall: float) -> tuple[Array, Array]:
    """Points (M, 2) [m] → which lie on walls (K,), and the walls' directions there (K, 2), of length 1.

    Next neighbours on a near wall are closer to each other than their noise: a direction between them would be
    anything, and a corridor would seem to have walls across it.
    """
    index = np.arange(len(points))
    most = np.minimum(index, index[::-1])
    steps = np.minimum(1, most)
    for step in range(2, NEIGHBOURS + 1):
        wider = np.minimum(step, most)
        longer = np.hypot(*(points[index + wider] - points[index - wider]).T) < wall
        steps = np.where(longer & (steps == step - 1), wider, steps)
    along = points[index + steps] - points[index - steps]
    reach = np.hypot(along[:, 0], along[:, 1])
    along = along / np.maximum(reach, 1e-9)[:, None]
    aside = points - points[index - steps]
    off = np.abs(along[:, 0] * aside[:, 1] - along[:, 1] * aside[:, 0])
    rows = np.flatnonzero((reach > 1e-6) & (reach < wall) & (off < BENT))
    return rows, along[rows]
